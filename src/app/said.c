#include "app/said.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static void hand_on(const struct gp_said *s, enum gp_level level,
                    const char *line)
{
    if (s->to && s->to->sink)
        s->to->sink(s->to->user, level, line);
}

/* False when memory is full. */
static bool keep(struct gp_said *s, enum gp_level level, const char *line)
{
    const size_t bytes = strlen(line) + 2;
    if (bytes > s->room - s->used) {
        const size_t room = 2 * s->room + bytes;
        char *const text = realloc(s->text, room);
        if (!text)
            return false;
        s->text = text;
        s->room = room;
    }
    s->text[s->used] = (char) level;
    memcpy(s->text + s->used + 1, line, bytes - 1);
    s->used += bytes;
    return true;
}

static void take(void *user, enum gp_level level, const char *line)
{
    struct gp_said *const s = user;
    char named[GP_LINE_BYTES];
    if (level == GP_LEVEL_BARE) {
        snprintf(named, sizeof named, "%s: %s", s->name, line);
        line = named;
        level = GP_LEVEL_ERROR;
    }
    if (level == GP_LEVEL_ERROR)
        snprintf(s->last, sizeof s->last, "%s", line);
    if (gp_flight_head(s->flight) != s->unit && keep(s, level, line))
        return;
    gp_said_flush(s);
    hand_on(s, level, line);
}

void gp_said_begin(struct gp_said *s, const struct gp_log *to,
                   const struct gp_flight *flight, int unit,
                   const char *name)
{
    *s = (struct gp_said) {
        .log = {take, s, to ? to->level : GP_LEVEL_ERROR},
        .to = to, .flight = flight, .unit = unit, .name = name,
    };
}

void gp_said_flush(struct gp_said *s)
{
    for (size_t at = 0; at < s->used; at += strlen(s->text + at + 1) + 2)
        hand_on(s, (enum gp_level) s->text[at], s->text + at + 1);
    s->used = 0;
}

void gp_said_end(struct gp_said *s)
{
    free(s->text);
    *s = (struct gp_said) {0};
}
