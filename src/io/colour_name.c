#include "io/colour_name.h"

#include <stdlib.h>
#include <string.h>
#include <strings.h>

size_t gp_layer_length(const char *name)
{
    const char *dot = strrchr(name, '.');
    return dot ? (size_t) (dot - name) + 1 : 0;
}

char *gp_colour_name(const char *name, int c)
{
    static const char *const spelling[][3] = {
        {"R", "G", "B"},
        {"red", "green", "blue"},
        {"Red", "Green", "Blue"},
        {"RED", "GREEN", "BLUE"},
    };
    const size_t layer = gp_layer_length(name);
    const char *own = name + layer, *want = spelling[0][c];
    for (size_t i = 0; i < sizeof spelling / sizeof *spelling; i++) {
        for (int k = 0; k < 3; k++) {
            if (strcmp(own, spelling[i][k]) == 0)
                want = spelling[i][c];
        }
    }
    char *made = malloc(layer + strlen(want) + 1);
    if (made) {
        memcpy(made, name, layer);
        strcpy(made + layer, want);
    }
    return made;
}

int gp_find_alpha(const struct gp_frame *f)
{
    const char *colour = NULL;
    for (int i = 0; i < f->channels && !colour; i++) {
        if (f->channel[i].colour >= 0)
            colour = f->channel[i].name;
    }
    if (!colour)
        return -1;
    const size_t layer = gp_layer_length(colour);
    for (int i = 0; i < f->channels; i++) {
        const char *name = f->channel[i].name;
        if (f->channel[i].colour < 0 && strncmp(name, colour, layer) == 0 &&
            (strcmp(name + layer, "A") == 0 ||
             strcasecmp(name + layer, "alpha") == 0))
            return i;
    }
    return -1;
}
