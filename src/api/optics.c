/* A lens's prescription and its first-order optics. */
#include "api/api.h"

#include "core/memory.h"
#include "sun/lens.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

struct own {
    struct gp_lens lens;
    struct gp_lens_ghost ghost[GP_LENS_GHOSTS];
    char *svg;
};

/* Copies what the caller reads. */
static void fill(const struct gp_lens *lens, const struct gp_lens_figures *f,
                 struct glarepp_lens *out)
{
    memcpy(out->name, lens->name, sizeof lens->name);
    memcpy(out->patent, lens->patent, sizeof lens->patent);
    memcpy(out->note, lens->note, sizeof lens->note);
    out->claims_focal = lens->claims_focal;
    out->claims_f_number = lens->claims_f_number;
    out->claims_back = lens->claims_back;
    out->claims_height = lens->claims_height;
    out->surfaces = lens->n;
    out->stop = lens->stop;
    out->blades = lens->blades;
    out->focal = f->focal;
    out->back = f->back;
    out->pupil = f->pupil;
    out->f_number = f->f_number;
    out->height = f->height;
    out->through = f->through;
}

int glarepp_lens(struct glarepp *gp, const char *lens, struct glarepp_lens *out)
{
    _Static_assert(sizeof out->name == sizeof ((struct gp_lens *) 0)->name &&
                       sizeof out->note == sizeof ((struct gp_lens *) 0)->note,
                   "texts are copied whole");
    const struct gp_api_call call = gp_api_begin(gp);
    struct gp_lens_figures figures;
    struct own *own = NULL;
    gp_status st;
    memset(out, 0, sizeof *out);
    GP_TRY(gp_alloc_zero(&gp->log, "lens", 1, sizeof *own, &own));
    out->own = own;
    GP_TRY(gp_lens_read(&gp->log, lens, &own->lens));
    GP_TRY(gp_lens_focus(&gp->log, &own->lens, INFINITY, 0.0));
    gp_lens_measure(&own->lens, &figures);
    fill(&own->lens, &figures, out);
    out->ghosts = gp_lens_ghosts(&own->lens, GP_D_LINE, own->ghost);
    GP_TRY(gp_alloc_zero(&gp->log, "ghosts", (size_t) out->ghosts + 1,
                         sizeof *out->ghost, &out->ghost));
    for (int i = 0; i < out->ghosts; i++) {
        const struct gp_lens_ghost *const g = &own->ghost[i];
        out->ghost[i] = (struct glarepp_ghost) {
            .first = g->first, .second = g->second, .a = g->m.a, .b = g->m.b,
            .radius = g->radius, .shift = g->shift, .through = g->through,
        };
    }
out:
    if (st)
        glarepp_lens_end(out);
    return gp_api_end(&call, st);
}

void glarepp_lens_end(struct glarepp_lens *lens)
{
    struct own *const own = lens->own;
    if (own)
        free(own->svg);
    gp_free(own);
    gp_free(lens->ghost);
    memset(lens, 0, sizeof *lens);
}

const char *glarepp_lens_draw(struct glarepp_lens *lens,
                              const struct glarepp_ghost *ghost)
{
    struct own *const own = lens->own;
    const struct gp_lens_ghost *drawn = NULL;
    size_t size = 0;
    for (int i = 0; ghost && i < lens->ghosts; i++) {
        if (own->ghost[i].first == ghost->first &&
            own->ghost[i].second == ghost->second)
            drawn = &own->ghost[i];
    }
    free(own->svg);
    own->svg = NULL;
    FILE *const f = open_memstream(&own->svg, &size);
    if (!f)
        return NULL;
    const bool whole = !gp_lens_svg(NULL, f, &own->lens, drawn) && !ferror(f);
    if (fclose(f) != 0 || !whole) {
        free(own->svg);
        own->svg = NULL;
    }
    return own->svg;
}
