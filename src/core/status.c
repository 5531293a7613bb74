// SPDX-License-Identifier: Apache-2.0
#include "core/status.h"

#include "core/minmax.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>

// -- text of files and libraries ---------------------------------------------

size_t gp_utf8_bytes(const char *text)
{
    const unsigned char *const s = (const unsigned char *) text;
    if (s[0] < 0x80)
        return 1;
    size_t n = s[0] >= 0xc2 && s[0] <= 0xdf   ? 2
               : s[0] >= 0xe0 && s[0] <= 0xef ? 3
               : s[0] >= 0xf0 && s[0] <= 0xf4 ? 4 : 0;
    unsigned char least = s[0] == 0xe0 ? 0xa0 : s[0] == 0xf0 ? 0x90 : 0x80;
    unsigned char most = s[0] == 0xed ? 0x9f : s[0] == 0xf4 ? 0x8f : 0xbf;
    for (size_t i = 1; i < n; i++) {
        if (s[i] < least || s[i] > most)
            return 0;
        least = 0x80;
        most = 0xbf;
    }
    return n;
}

size_t gp_control_bytes(const char *text)
{
    const unsigned char *const s = (const unsigned char *) text;
    const size_t n = gp_utf8_bytes(text);
    switch (n) {
    case 0: // C1 of 8-bit terminals
        return s[0] < 0xa0;
    case 1: // C0, DEL
        return s[0] && (s[0] < ' ' || s[0] == 0x7f);
    case 2: // C1; U+061C
        return (s[0] == 0xc2 && s[1] < 0xa0) ||
               (s[0] == 0xd8 && s[1] == 0x9c) ? n : 0;
    case 3: // U+200E, U+200F, U+2028 to U+202E, U+2066 to U+2069
        return s[0] == 0xe2 &&
               ((s[1] == 0x80 && ((s[2] >= 0x8e && s[2] <= 0x8f) ||
                                  (s[2] >= 0xa8 && s[2] <= 0xae))) ||
                (s[1] == 0x81 && s[2] >= 0xa6 && s[2] <= 0xa9)) ? n : 0;
    default:
        return 0;
    }
}

void gp_make_printable(char *text)
{
    while (*text) {
        const size_t n = gp_control_bytes(text);
        const size_t whole = gp_utf8_bytes(text);
        if (n)
            memset(text, strchr("\t\n\r", *text) ? ' ' : '?', n);
        text += whole ? whole : 1;
    }
}

struct gp_printable gp_printable(const char *text)
{
    struct gp_printable p;
    snprintf(p.text, sizeof p.text, "%s", text);
    gp_make_printable(p.text);
    return p;
}

// -- messages ----------------------------------------------------------------

gp_status(gp_print)(const struct gp_log *log, enum gp_level level,
                    gp_status status, const char *parameter, const char *fmt,
                    ...)
{
    char text[GP_LINE_BYTES];
    const struct gp_line line = {level, status, parameter, text};
    va_list args;
    if (!log || !log->sink || (level > log->level && level != GP_LEVEL_BARE))
        return status;
    va_start(args, fmt);
    vsnprintf(text, sizeof text, fmt, args);
    va_end(args);
    gp_make_printable(text);
    log->sink(log->user, &line);
    return status;
}

const char *gp_status_text(gp_status status)
{
#define ROW(name, code, text)                                                 \
    case name:                                                                \
        return text;
    switch (status) {
        GP_STATUS_LIST(ROW)
    }
#undef ROW
    return "unknown status";
}

// -- misspelt names -----------------------------------------------------------

struct gp_nearest gp_nearest_to(const char *word, size_t length, int most)
{
    // a word that is half wrong is no match
    const int half = length < 64 ? (int) length / 2 : 0;
    return (struct gp_nearest) {
        .word = word, .length = length, .most = gp_min(most, half),
    };
}

void gp_nearest_try(struct gp_nearest *search, const char *name)
{
    enum { LONGEST = 255 };
    const char *const word = search->word;
    const size_t n = search->length, m = strlen(name);
    int rows[3][LONGEST + 1]; // the last three of the table of distances
    if (n > LONGEST || m > LONGEST)
        return;
    for (size_t j = 0; j <= m; j++)
        rows[0][j] = (int) j;
    for (size_t i = 1; i <= n; i++) {
        int *const row = rows[i % 3];
        const int *const above = rows[(i - 1) % 3];
        row[0] = (int) i;
        for (size_t j = 1; j <= m; j++) {
            const bool same = word[i - 1] == name[j - 1];
            row[j] = gp_min(above[j - 1] + !same,
                            gp_min(above[j], row[j - 1]) + 1);
            if (i > 1 && j > 1 && word[i - 1] == name[j - 2] &&
                word[i - 2] == name[j - 1])
                row[j] = gp_min(row[j], rows[(i - 2) % 3][j - 2] + 1);
        }
    }
    const int edits = rows[n % 3][m];
    if (search->name ? edits < search->most : edits <= search->most) {
        search->most = edits;
        search->name = name;
    }
}
