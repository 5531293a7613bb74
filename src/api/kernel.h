/* The library's kernel handle. */
#ifndef GP_API_KERNEL_H
#define GP_API_KERNEL_H

#include "api/api.h"
#include "glare/kernel_kept.h"

struct glarepp_kernel {
    struct glarepp *gp;
    struct gp_kernel_request request;
    char *text[GP_RECIPES]; // of each recipe; owned
    char *path[GP_RECIPES]; // of each image, for messages; owned, or NULL
};

#endif
