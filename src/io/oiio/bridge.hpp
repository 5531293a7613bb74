// Inside the OpenImageIO bridge: what its two halves share. Only the .cpp
// files of the bridge see this.
#ifndef GP_IO_OIIO_BRIDGE_HPP
#define GP_IO_OIIO_BRIDGE_HPP

#include "io/oiio/oiio.h"

#include <OpenImageIO/imageio.h>

#include <cstddef>
#include <string>

// Puts one line into `why`, cut to its size and always terminated, with line
// ends turned into spaces. Returns -1, or GP_OIIO_MEMORY when the text says
// that memory is full, so that a failure is one expression.
int gp_oiio_why(char *why, std::size_t why_size, const std::string &text);

// The same of the exception that is being handled, for a `catch (...)`.
int gp_oiio_caught(char *why, std::size_t why_size);

// Throws std::runtime_error for an image of `format` in `size` bytes that is
// not to be read: no picture, over max_pixels, or more than the bytes hold.
// Four channels or less count as one. In oiio_limits.cpp.
void gp_oiio_check_size(const OIIO::ImageSpec &spec, const char *format,
                        std::size_t size, long long max_pixels);

// The write half, in oiio_write.cpp; contracts as in gp_oiio_api.
int gp_oiio_write(const char *path, const char *format,
                  const struct gp_oiio_image *img, const char *type,
                  const char *compression, char *why, std::size_t why_size);
int gp_oiio_can_write(const char *format);

#endif
