#include "io/format.h"

#include <string.h>

/* The words that formats begin with. `image`: OpenImageIO has a reader. */
static const struct {
    const char *name;
    const char *bytes;
    size_t n, at;
    bool image;
} word[] = {
    {"EXR", "\x76\x2f\x31\x01", 4, 0, true},
    {"PNG", "\x89PNG", 4, 0, true},
    {"JPEG", "\xff\xd8\xff", 3, 0, true},
    {"TIFF", "II*\0", 4, 0, true}, // and most cameras' raw files
    {"TIFF", "MM\0*", 4, 0, true},
    {"TIFF", "II+\0", 4, 0, true}, // over 4 GiB
    {"TIFF", "MM\0+", 4, 0, true},
    {"Radiance HDR", "#?", 2, 0, true},
    {"DPX", "SDPX", 4, 0, true},
    {"DPX", "XPDS", 4, 0, true},
    {"Cineon", "\x80\x2a\x5f\xd7", 4, 0, true},
    {"Cineon", "\xd7\x5f\x2a\x80", 4, 0, true},
    {"WebP or AVI", "RIFF", 4, 0, true},
    {"GIF", "GIF8", 4, 0, true},
    {"BMP", "BM", 2, 0, true},
    {"icon", "\0\0\1\0", 4, 0, true},
    {"IFF", "FOR4", 4, 0, true},
    {"JPEG 2000", "\0\0\0\x0cjP", 6, 0, true},
    {"JPEG 2000", "\xff\x4f\xff\x51", 4, 0, true},
    {"Photoshop", "8BPS", 4, 0, true},
    {"SGI", "\x01\xda", 2, 0, true},
    {"Softimage", "\x53\x80\xf6\x34", 4, 0, true},
    {"FITS", "SIMPLE", 6, 0, true},
    {"HEIF, AVIF or a movie", "ftyp", 4, 4, true},
    {"a movie", "\0\0\1\xba", 4, 0, true},
    {"DDS", "DDS ", 4, 0, true},
    {"DICOM", "DICM", 4, 128, true},
    {"Zfile", "\x2f\x08\x67\xab", 4, 0, true},
    {"Zfile", "\xab\x67\x08\x2f", 4, 0, true},
    {"a camera's raw file", "FUJIFILM", 8, 0, true},
    {"a camera's raw file", "IIRO", 4, 0, true},
    {"a camera's raw file", "IIRS", 4, 0, true},
    {"a camera's raw file", "MMOR", 4, 0, true},
    {"a camera's raw file", "IIU\0", 4, 0, true},
    {"a camera's raw file", "II\x1a\0", 4, 0, true},
    {"a camera's raw file", "\0MRM", 4, 0, true},
    {"a camera's raw file", "FOVb", 4, 0, true},
    {"gzip", "\x1f\x8b", 2, 0, true}, // Zfile may be packed so
    {"zip", "PK\x03\x04", 4, 0, false},
    {"a web page", "<!DOC", 5, 0, false},
    {"a web page", "<html", 5, 0, false},
    {"a git-lfs pointer", "version https://", 16, 0, false},
};
enum { WORDS = sizeof word / sizeof *word };

/* PBM, PGM, PPM and PFM: "P", a letter, white space or a comment. */
static const char *netpbm(const uint8_t *b, size_t n)
{
    if (n < 3 || b[0] != 'P' || !b[2] || !strchr(" \t\n\v\f\r#", b[2]))
        return NULL;
    if (b[1] == 'F' || b[1] == 'f')
        return "PFM";
    return b[1] >= '1' && b[1] <= '6' ? "PNM" : NULL;
}

static int find_word(const uint8_t *b, size_t n)
{
    for (int i = 0; i < WORDS; i++) {
        if (n >= word[i].at + word[i].n &&
            memcmp(b + word[i].at, word[i].bytes, word[i].n) == 0)
            return i;
    }
    return -1;
}

/* Targa's header of 18 bytes: bytes for the name, palette or none, kind of
 * pixels, ..., width and height, bits of a pixel. */
static bool is_targa(const uint8_t *b, size_t n)
{
    return n >= 18 && b[1] <= 1 &&
           ((b[2] >= 1 && b[2] <= 3) || (b[2] >= 9 && b[2] <= 11)) &&
           (b[12] | b[13]) && (b[14] | b[15]) &&
           (b[16] == 15 || (b[16] % 8 == 0 && b[16] >= 8 && b[16] <= 32));
}

/* RLA, big-endian: two windows, frame, kind of channels, at 20 how many of
 * colour, matte and others there are, at 26 the revision, which some writers
 * leave 0. */
static bool is_rla(const uint8_t *b, size_t n)
{
    return n >= 28 && b[20] == 0 && b[21] > 0 &&
           ((b[26] == 0xff && b[27] == 0xfe) || (b[26] == 0 && b[27] == 0));
}

const char *gp_format_name(const uint8_t *first, size_t n)
{
    const char *const pnm = netpbm(first, n);
    const int i = pnm ? -1 : find_word(first, n);
    return i < 0 ? pnm : word[i].name;
}

bool gp_format_reads(const uint8_t *first, size_t n)
{
    const int i = find_word(first, n);
    return i >= 0 ? word[i].image
                  : netpbm(first, n) || is_targa(first, n) || is_rla(first, n);
}
