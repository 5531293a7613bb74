// SPDX-License-Identifier: Apache-2.0
/* The veil that a picture's light lays over the place which an eye looks at, and what
 * lighting engineers make of it, in cd/m2, lux and their indices. With L of a pixel, W its
 * solid angle, t its angle from the line of sight, under 90 degrees:
 *
 *   E    = sum L W cos t, at the eye, upright to the line of sight
 *   L_v  = sum L W cos t f(t), t from 0.5 degrees on, f the general equation of CIE 146
 *          (2002), 0.1 to 100 degrees, of age and pigment
 *   L_b  = mean of L over the fixated degree, t < 0.5
 *   TI   = 65 L_v / L_b^0.8, over 5 cd/m2 95 L_v / L_b^1.05 (CIE 31 and CIE 140), of the
 *          L_v of glare sources only, as these are about luminaires
 *
 * Glare sources are pixels over 5 times the mean luminance of the half space before the
 * eye that the picture shows, joined where they are within 0.1 rad, as evalglare's -b 5
 * and -r 0.2 do without a task; by cells of 0.05. Of each the mean L, W, the position
 * index P of Guth above the line of sight (IES; CIE 117 has its table), of Iwata (1992)
 * below it, at most 16, as evalglare has them:
 *
 *   UGR  = 8 log10(0.25 / L_a sum L^2 W / P^2), CIE 117 (1995), L_a = (E - E_s) / pi
 *          without the E_s of the sources
 *   DGP  = 5.87e-5 E + 0.0918 log10(1 + sum L^2 W / (E^1.87 P^2)) + 0.16, at most 1:
 *          Wienold and Christoffersen 2006, eq. 7; for E over 380 lux
 *
 * Lights of flux beside the picture count in all of them, as those in it: each is of
 * what the eye meets. Other light beside it is in none. A pixel or lamp near the place
 * that the eye looks at, over its size, counts in parts of a twentieth of its angle. */
#ifndef GP_GLARE_VEIL_H
#define GP_GLARE_VEIL_H

#include "core/image.h"
#include "core/projection.h"
#include "core/status.h"

/* A light that no pixel has. */
struct gp_veil_lamp {
    double at[2];     // its middle, EXR pixel space
    double half[2];   // its disc's width and height, pixels, > 0
    double luminance; // of scene value 1, all over it
};

struct gp_veil_params {
    struct gp_projection projection; // of EXR pixel space, no PLANE
    double at[2];                    // where the eye looks, EXR pixel space
    double white;                    // cd/m2 of scene value 1, > 0
    double age, pigment;             // as of the model cie
    const struct gp_veil_lamp *lamp; // `lamps` of them
    int lamps;
};

/* Measures f->rgb, which is clean, and writes out->veil: `missing` where p->at has no
 * direction. The same for any number of threads. */
struct glarepp_facts;
GP_MUST_CHECK gp_status gp_veil_measure(const struct gp_log *log,
                                        const struct gp_veil_params *p,
                                        const struct gp_image *f,
                                        struct glarepp_facts *out);

#endif
