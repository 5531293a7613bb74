// SPDX-License-Identifier: Apache-2.0
/* The sums of a level: of light on its nodes or pixels, times weights that change
 * from place to place. */
#ifndef GP_GLARE_SKY_SUM_H
#define GP_GLARE_SKY_SUM_H

#include "glare/sky/sky_priv.h"

/* Planes of a level's light, with black around them as far as weights reach. */
struct gp_sky_grid {
    int w, h, rx, ry; // nodes; black ones on each side
    size_t pitch;
    float *v[3]; // of node (0, 0); v[0] - `before` is owned
    size_t before;
};
GP_MUST_CHECK gp_status gp_sky_grid_make(const struct gp_log *log,
                                         const struct gp_sky_level *g,
                                         struct gp_sky_grid *out);
void gp_sky_grid_free(struct gp_sky_grid *g);

static inline float *gp_sky_grid_row(const struct gp_sky_grid *g, int c, int y)
{
    return g->v[c] + (ptrdiff_t) y * (ptrdiff_t) g->pitch;
}

/* Floats of a row of n pixels, with room for whole blocks: an odd number of these, so
 * that rows do not share lines of a cache. */
static inline size_t gp_sky_row_room(int n)
{
    return (((size_t) n + 2 * GP_SKY_BLOCK - 1) / GP_SKY_BLOCK | 1) *
           GP_SKY_BLOCK;
}

/* For each row of a frame and each block of columns, its first source: at
 * [row][block], one more than blocks in a row. */
struct gp_sky_index {
    const struct gp_sources *src;
    int blocks;
    uint32_t *at; // owned
};
GP_MUST_CHECK gp_status gp_sky_index_make(const struct gp_log *log,
                                          const struct gp_sources *src,
                                          struct gp_sky_index *out);

static inline uint32_t *gp_sky_index_row(const struct gp_sky_index *index,
                                         int y)
{
    return index->at + (size_t) y * (size_t) (index->blocks + 1);
}

/* Floats of scratch for a thread. */
size_t gp_sky_room(const struct gp_sky *s);

// -- weights of a block: sum.c ---------------------------------------------------

enum {
    GP_SKY_LANES = 8,
    GP_SKY_PAD =
        2 * GP_SKY_BLOCK, // zeros on both sides of a block's weights, for
                          // sources of whole blocks that do not reach it
};

/* Weights of a group of rows. They are found for its middle, for each column of places
 * when a block asks; those of a block are linear between its first column and the next
 * block's. Where the level tilts they are linear in the row, too. */
struct gp_sky_weights {
    const struct gp_sky *s;
    const struct gp_sky_level *g;
    int place;      // first row of four
    float at[2][4]; // their weights; and by how much these grow with a row
    double middle;  // row of the group
    double row[GP_SKY_BAND][4]; // weights in each row
    float *places;              // [2][column of places][g->size]
    bool *known;                // of each
    size_t pitch, table;        // of rows of tables; of tables
    float *value;  // [value, its slope along, its slope down, that one's slope
                   // along][ry + dy][GP_SKY_PAD + rx + dx]
    short *span;   // as g->span
    short *column; // [rx + dx][2]: rows that are not 0, from and to: 4 at least
    short *laid;   // as span, of what may not be 0 in the tables
    short *spans;  // as span, of each column of places
    int spanned;   // places that `span` is of; -1: none
    int block;     // of the end of `value`; -1: none
    bool by_wide;  // vectors of BLOCK are there
};

/* Floats of scratch that weights of a level take. */
size_t gp_sky_weights_room(const struct gp_sky *s,
                           const struct gp_sky_level *g);

/* Opens weights for the rows [first, first + n) of a level, in scratch; returns what
 * is left of that. */
float *gp_sky_weights_open(const struct gp_sky *s, int level, int first, int n,
                           float *scratch, struct gp_sky_weights *w);

/* Finds the weights of block i, of BLOCK columns or half of them. */
void gp_sky_find_block(struct gp_sky_weights *w, int i);

/* Weight i of a table in the group's row r and column `lane` of the block. */
static inline float gp_sky_weight_at(const struct gp_sky_weights *w, size_t i,
                                     float lane, int r)
{
    const float *const v = w->value + i;
    const float along = v[0] + lane * v[w->table];
    return along +
           (float) (r - w->middle) * (v[2 * w->table] + lane * v[3 * w->table]);
}

/* Fills the factors that make the sum of a block's weights right in each of n rows. */
void gp_sky_find_factors(const struct gp_sky_weights *w, int i, int n,
                         float *factor);

/* Sum light around a block of ROWS rows, from column x and the group's row r on: dense,
 * which has row r as y; or, added, that of the sources [from, to) of a row, which is
 * `down` rows above r. */
void gp_sky_sum_dense(const struct gp_sky_weights *w,
                      const struct gp_sky_grid *light, int x, int y, int r,
                      float sum[GP_SKY_ROWS][3][GP_SKY_BLOCK]);
void gp_sky_sum_few(const struct gp_sky_weights *w,
                    const struct gp_sources *src, uint32_t from, uint32_t to,
                    int x, int down, int r,
                    float sum[GP_SKY_ROWS][3][GP_SKY_BLOCK]);

/* Puts a block's sums, times factors, into n rows of so many columns: of channel c and
 * row r at to + r * down + c * across. */
void gp_sky_put_block(float sum[GP_SKY_ROWS][3][GP_SKY_BLOCK],
                      const float *factor, int columns, int n, size_t down,
                      size_t across, float *to);

/* Sums a row of a level whose weights are found for each node; `light` has it as row
 * y. Of channel c at to + c * across. */
void gp_sky_sum_nodes(const struct gp_sky *s, int level, int row,
                      const struct gp_sky_grid *light, int y, size_t across,
                      float *to, float *scratch);

// -- rows -----------------------------------------------------------------------

/* Writes the rows of a group, level.rows of them or as many as there are, of what a
 * level spreads. */
void gp_sky_spread(const struct gp_sky *s, int level,
                   const struct gp_sky_grid *light, int group,
                   float *const out[3], float *scratch);

/* Fills n rows of pixels, BAND at most, with what near sources spread:
 * rows[row][channel]. */
void gp_sky_near(const struct gp_sky *s, const struct gp_sky_index *index,
                 int first, int n, float *rows, float *scratch);

#endif
