#include "core/plane.h"

#include "core/memory.h"

#include <stdlib.h>

void gp_plane_free(struct gp_plane *p)
{
    gp_free(p->v);
    free(p->name);
    *p = (struct gp_plane) {0};
}
