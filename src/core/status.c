#include "core/status.h"

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

void gp_make_printable(char *text)
{
    while (*text) {
        const unsigned char *const s = (const unsigned char *) text;
        const size_t n = gp_utf8_bytes(text);
        // C1: U+0080 to U+009F, or in 8-bit terminals the bytes themselves
        const bool c1 = n == 2 ? s[0] == 0xc2 && s[1] < 0xa0
                               : n == 0 && s[0] < 0xa0;
        if (strchr("\t\n\r", *text))
            *text = ' ';
        else if (s[0] < ' ' || s[0] == 127 || c1)
            memset(text, '?', n ? n : 1);
        text += n ? n : 1;
    }
}

// -- messages ----------------------------------------------------------------

static void send_line(const struct gp_log *log, enum gp_level level,
                      const char *fmt, va_list args)
{
    if (!log || !log->sink || (level > log->level && level != GP_LEVEL_BARE))
        return;
    char line[GP_LINE_BYTES];
    vsnprintf(line, sizeof line, fmt, args);
    gp_make_printable(line);
    log->sink(log->user, level, line);
}

gp_status (gp_fail)(const struct gp_log *log, gp_status status,
                    const char *fmt, ...)
{
    va_list args;
    va_start(args, fmt);
    send_line(log, GP_LEVEL_ERROR, fmt, args);
    va_end(args);
    return status;
}

gp_status (gp_fail_bare)(const struct gp_log *log, gp_status status,
                         const char *fmt, ...)
{
    va_list args;
    va_start(args, fmt);
    send_line(log, GP_LEVEL_BARE, fmt, args);
    va_end(args);
    return status;
}

static const char no_memory[] = "%s: out of memory; close other programs";

gp_status (gp_no_memory)(const struct gp_log *log, const char *file)
{
    return gp_fail(log, GP_ERR_BUG, no_memory, file);
}

gp_status (gp_no_memory_bare)(const struct gp_log *log, const char *what)
{
    return gp_fail_bare(log, GP_ERR_BUG, no_memory, what);
}

void gp_say(const struct gp_log *log, enum gp_level level, const char *fmt, ...)
{
    va_list args;
    va_start(args, fmt);
    send_line(log, level, fmt, args);
    va_end(args);
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
