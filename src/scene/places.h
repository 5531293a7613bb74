/* Places in a pixel at which a renderer may have looked, and their weights. */
#ifndef GP_SCENE_PLACES_H
#define GP_SCENE_PLACES_H

enum {
    GP_PLACES_BITS = 6,
    GP_PLACES = 1 << GP_PLACES_BITS,
    GP_MEANS = 6, // albedo and normal
};

/* Sets places, pixels from the middle, that have the density of Blender's
 * filter: no two share a row or a column (Hammersley's set), as edges along
 * these are frequent. */
void gp_places_set(double place[GP_PLACES][2]);

/* Weighs places so that their mean comes near the frame's: the renderer's
 * places are random, and met its surfaces in other shares (the regression
 * estimator of Deville and Sarndal 1992). of      albedo, about 1 or less, and
 * unit normal of each place; 0: none frame   the same of the pixel weight  >=
 * 0; of sum 1 where none is cut at 0 */
void gp_places_weigh(const double of[GP_PLACES][GP_MEANS],
                     const double frame[GP_MEANS], double weight[GP_PLACES]);

#endif
