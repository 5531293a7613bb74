#include "cli/options.h"

#include <stddef.h>
#include <string.h>

/* The usual threshold, 1, is the display's white: the part of light below it is
 * shown as it is. A style names another only with a reason.
 *
 * The glare index is that of ISO 9358:1994, here in the middle of a black area
 * of 1 degree in an endless bright field; the unit test of styles measures it.
 * Degrees are of the usual angle of view, 30 degrees for the height of a frame
 * without a camera: on 35 mm film, 24 mm high, that of a lens of 45 mm. */

/* A corrected lens's image of a point has wings: Moffat 1969, eq. 7. 6 % of the
 * light leaves its place, half of that to less than 0.07 degree. */
#define CORE "moffat:share=.06,fwhm=.1,beta=2.5"

/* Veil: with core and iris a glare index of 0.75 %, the most that lifts the
 * blacks of no frame by day by over 8 codes (styles.t): a tree before the sky.
 * It falls with the fourth power of the distance. Measured spread functions
 * fall steeply over the first degrees, too (Talvala et al. 2007); one that is
 * even over the frame would lift each black by the index. */
#define VEIL "moffat:share=.012,fwhm=.6,beta=2"

const struct gp_style gp_styles[] = {
    {"camera", "a modern lens: a soft core, a thin veil, its iris' diffraction",
     {
        "kernel", CORE,
        "kernel", VEIL,
        // The iris, round by its blades: Airy's pattern falls with the cube of
        // the angle, as a Moffat of beta 1.5. A stop of D mm sends the share
        // 2 l / (pi^2 D t) of its light farther than t radians; 35 mm at f/4
        // and 550 nm: .00073 / t, t in degrees, which is share times fwhm /
        // 1.53.
        // Rays of straight blades would take 18 ms more of 110 in 1920x1080.
        "kernel", "moffat:share=.028,fwhm=.04,beta=1.5",
     }},
    {"vintage", "bare glass of 1902: a wide veil, and the ghosts of a Tessar",
     {
        // Rudolph's Tessar, US 721,240: light bounces twice off its bare glass
        "lens", "tessar",
        "kernel", "moffat:share=.09,fwhm=.14,beta=2", // less corrected
        // With that a glare index of 3.3 % beside the ghosts, chosen on frames:
        // 15 pairs of 6 surfaces that each reflect ((n - 1) / (n + 1))^2, 5.5 %
        // at n = 1.61, send 4.5 % of the light astray.
        "kernel", "moffat:share=.03,fwhm=3,beta=1.5",
     }},
    {"mist", "a diffusion filter: a wide halo around all light, lifted blacks",
     {
        "threshold", "0", // glass before the lens spreads all light alike
        // No maker gives figures. Chosen on frames: a glare index of 10 %, of
        // which 3 % is as wide as the frame: blacks far from light.
        "kernel", "moffat:share=.1,fwhm=.8,beta=1.5",
        "kernel", "moffat:share=.03,fwhm=6,beta=1.5",
     }},
    {"anamorphic", "a squeezing lens: blue streaks, oval ghosts",
     {
        "threshold", "2", // a stop over white: streaks are of lamps, not walls
        "kernel", CORE,
        "kernel", VEIL,
        // Light that a front cylinder reflects spreads along one line; coatings
        // reflect the blue end most. Strength, colour: chosen on frames.
        "kernel", "streak:share=.02,red=.08,green=.3",
        "flare", "preset:oval", // half as wide as high: a squeeze of 2
     }},
    {"halation", "film without a backing: red halos around lights",
     {
        "kernel", CORE,
        // Base and index of film: the model's own. Half of what the emulsion
        // scatters is beyond the critical angle (1 - 1 / n^2 = 0.54); of the
        // share that reaches the base no figure was found: chosen on frames.
        "kernel", "halation:share=.009",
     }},
    {"star", "a cross screen filter: four fine rays",
     {
        "kernel", CORE,
        "kernel", VEIL,
        // two sets of engraved lines, at right angles, as such filters have;
        // the share of the glass that they cover: chosen on frames
        "kernel", "cross:share=.05",
     }},
    {"eye", "the human eye in daylight (Spencer et al. 1995)",
     {"kernel", "builtin:eye"}},
    {"eye-night", "the eye at night, with its halo and needles",
     {"kernel", "builtin:eye-night"}},
    {0},
};

const struct gp_style *gp_style_of(const char *name)
{
    const struct gp_style *s = gp_styles;
    while (strcmp(s->name, name) != 0)
        s++;
    return s;
}

bool gp_style_sets(const char *style, const char *option)
{
    const char *const *word = gp_style_of(style)->word;
    while (*word && strcmp(*word, option) != 0)
        word += 2;
    return *word != NULL;
}

const char *gp_style_name(int i, const char **text)
{
    *text = gp_styles[i].text;
    return gp_styles[i].name;
}
