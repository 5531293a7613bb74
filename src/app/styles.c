#include "app/styles.h"

#include <stddef.h>
#include <string.h>

/* The usual threshold, 1, is the display's white: darker light is shown as it
 * is, and the frame holds its glare. A style names another only with a reason.
 *
 * Degrees are of the usual angle of view, 30 degrees for the height of a frame
 * without a camera: of 35 mm film (24 mm high) a lens of 45 mm. */
const struct gp_style gp_styles[] = {
    {"camera", "a modern lens: a soft core, a thin veil, faint rays of its iris",
     {
        // The point image of a corrected lens with wings: Moffat 1969, eq. 7.
        // 6 % of the light leaves the pixel, half of that stays within 0.1
        // degree.
        "kernel", "moffat:share=.06,fwhm=.1,beta=2.5",
        // Veiling glare after ISO 9358:1994, the light in the middle of a black
        // area of a bright field: 0.8 % for one of 1 degree, with the core
        // (test_styles). Good lenses have 0.5 to 3 %. It falls with the 4th
        // power, as measured spread functions fall over the first degrees:
        // Talvala et al. 2007, McCann and Rizzi 2007.
        "kernel", "moffat:share=.015,fwhm=.6,beta=2",
        // Rays of 9 blades, so 18. Of a stop of D mm the share 2 l / (pi^2 D t)
        // of the light goes farther than t (Airy's pattern, encircled energy):
        // 35 mm at f/4, 550 nm, 0.05 degree: 1.5 %; rounded blades smear half.
        "kernel", "star:share=.007,points=18,strands=1,core=.05,length=2,"
        "width=.008",
     }},
    {"vintage", "bare glass of 1902: a warm veil and the ghosts of a Tessar",
     {
        // Rudolph's Tessar, US 721,240, whose surfaces reflect as glass does
        "lens", "tessar",
        "kernel", "moffat:share=.09,fwhm=.14,beta=2",
        "kernel", "moffat:share=.03,fwhm=3,beta=1.5",
     }},
    {"mist", "a diffusion filter: a wide halo, lifted blacks, all light takes part",
     {
        "threshold", "0",
        "kernel", "moffat:share=.13,fwhm=.8,beta=1.5",
        "kernel", "moffat:share=.05,fwhm=6,beta=1.5",
     }},
    {"anamorphic", "a squeezing lens: a blue streak, oval ghosts",
     {
        "threshold", "2",
        "kernel", "moffat:share=.06,fwhm=.1,beta=2.5",
        "kernel", "moffat:share=.015,fwhm=.6,beta=2",
        "kernel", "streak:share=.03",
     }},
    {"halation", "film without a backing: red halos around lights",
     {
        "kernel", "moffat:share=.06,fwhm=.1,beta=2.5",
        "kernel", "halation:share=.012",
     }},
    {"star", "a cross screen filter: four fine rays",
     {
        "kernel", "moffat:share=.06,fwhm=.1,beta=2.5",
        "kernel", "moffat:share=.015,fwhm=.6,beta=2",
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

const char *gp_style_name(int i, const char **text)
{
    *text = gp_styles[i].text;
    return gp_styles[i].name;
}
