#include "core/status.h"

#include <stdarg.h>
#include <stdio.h>

static void say(const struct gp_log *log, enum gp_level level, const char *fmt,
                va_list args)
{
    if (!log || !log->sink || (level > log->level && level != GP_LEVEL_BARE))
        return;
    char line[GP_LINE_BYTES];
    vsnprintf(line, sizeof line, fmt, args);
    for (char *c = line; *c; c++) { // one message is one line that moves no
        const unsigned char code = (unsigned char) *c; // cursor, whatever a
        if (code < ' ' || code == 127) // file name or a library put into it
            *c = ' ';
    }
    log->sink(log->user, level, line);
}

gp_status (gp_fail)(const struct gp_log *log, gp_status status,
                    const char *fmt, ...)
{
    va_list args;
    va_start(args, fmt);
    say(log, GP_LEVEL_ERROR, fmt, args);
    va_end(args);
    return status;
}

gp_status (gp_fail_bare)(const struct gp_log *log, gp_status status,
                         const char *fmt, ...)
{
    va_list args;
    va_start(args, fmt);
    say(log, GP_LEVEL_BARE, fmt, args);
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
    say(log, level, fmt, args);
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
