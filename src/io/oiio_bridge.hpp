// Inside the OpenImageIO bridge: what its two halves share. Only the .cpp
// files of the bridge see this.
#ifndef GP_IO_OIIO_BRIDGE_HPP
#define GP_IO_OIIO_BRIDGE_HPP

#include "io/oiio.h"

#include <cstddef>
#include <string>

// Puts one line into `why`, cut to its size and always terminated, with line
// ends turned into spaces. Returns -1, so that a failure is one expression.
int gp_oiio_why(char *why, std::size_t why_size, const std::string &text);

// The write half, in oiio_write.cpp; contracts as in gp_oiio_api.
int gp_oiio_write(const char *path, const char *format,
                  const struct gp_oiio_image *img, const char *type,
                  const char *compression, char *why, std::size_t why_size);
int gp_oiio_can_write(const char *format);

#endif
