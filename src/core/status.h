// SPDX-License-Identifier: Apache-2.0
/* Status codes and the error line.
 *
 * One list makes the enum, the exit statuses and the texts of the man page.
 * A function that can fail returns gp_status; gp_fail() prints the message
 * where the failure is detected, with the values that were found. */
#ifndef GP_CORE_STATUS_H
#define GP_CORE_STATUS_H

#include <stdbool.h>
#include <stddef.h>

#define GP_STATUS_LIST(X)                                                     \
    X(GP_OK, 0, "done")                                                       \
    X(GP_ERR_USAGE, 2, "the command line is wrong")                           \
    X(GP_ERR_IO, 3, "a file could not be read or written")                    \
    X(GP_ERR_DATA, 4, "a file holds bad data")                                \
    X(GP_ERR_GL, 5, "no GL context could be made")                            \
    X(GP_ERR_FRAMES, 6, "some frames of a sequence failed")                   \
    X(GP_ERR_CANCELLED, 7, "cancelled by the library's caller")               \
    X(GP_ERR_BUG, 70, "a bug, or out of memory")

#define GP_STATUS_ENUM(name, code, text) name = (code),
typedef enum gp_status { GP_STATUS_LIST(GP_STATUS_ENUM) } gp_status;

#define GP_MUST_CHECK __attribute__((warn_unused_result))
#define GP_UNUSED __attribute__((unused)) // a parameter
#define GP_PRINTF(fmt, args) __attribute__((format(printf, fmt, args)))

/* BARE is an error whose line names no file ("sensors: out of memory"): the
 * sink adds the file's name in front. No gp_log has it as level. */
enum gp_level { GP_LEVEL_ERROR, GP_LEVEL_WARN, GP_LEVEL_INFO, GP_LEVEL_BARE };

enum { GP_LINE_BYTES = 4096 }; // longer lines are cut

/* A message, valid until its receiver returns. */
struct gp_line {
    enum gp_level level;
    gp_status status;      // of an error
    const char *parameter; // of the library's caller that is wrong or helps, as
                           // its field in glarepp.h; "": none
    const char *text;      // one line, without its newline
};

/* Receiver of messages. A NULL log is silent. Messages over `level` are dropped,
 * errors never. */
struct gp_log {
    void (*sink)(void *user, const struct gp_line *line);
    void *user;
    enum gp_level level;
};

/* Prints a line of a log, about a parameter or "", and returns `status`. Calls go through
 * the names below. */
gp_status gp_print(const struct gp_log *log, enum gp_level level,
                   gp_status status, const char *parameter, const char *fmt,
                   ...) GP_PRINTF(5, 6);
#ifdef __clang_analyzer__ // it cannot see that it returns its status
#define gp_print(log, level, status, ...) \
    ((void) (gp_print) (log, level, status, __VA_ARGS__), (status))
#endif

/* gp_fail(log, status, fmt, ...) prints one error line and returns `status`, so that a
 * failure is one expression: return gp_fail(log, GP_ERR_DATA, "%s: ...", path, ...);
 *
 * The form is "FILE: what is wrong (what was found); what to do".
 * Never call it inside a parallel body: return a status there, and let the
 * caller that owns the loop print the line. */
#define gp_fail(log, status, ...) \
    gp_print(log, GP_LEVEL_ERROR, status, "", __VA_ARGS__)

/* The same for a line that names no file: GP_LEVEL_BARE. */
#define gp_fail_bare(log, status, ...) \
    gp_print(log, GP_LEVEL_BARE, status, "", __VA_ARGS__)

/* gp_fail_at(log, status, parameter, fmt, ...): the same for what is wrong with a
 * parameter, or what a parameter helps with. The line names no option: only the caller's
 * caller knows where the parameter comes from. A word after the field tells messages apart
 * that need other help: "layer.gl.osmesa". */
#define gp_fail_at(log, status, ...) \
    gp_print(log, GP_LEVEL_ERROR, status, __VA_ARGS__)

/* Both: about a parameter, and GP_LEVEL_BARE. */
#define gp_fail_bare_at(log, status, ...) \
    gp_print(log, GP_LEVEL_BARE, status, __VA_ARGS__)

/* The one line for a full memory: "FILE: out of memory; close other programs".
 * Returns GP_ERR_BUG. gp_no_memory_bare() is for a `what` that names no file:
 * "frame list". */
#define GP_NO_MEMORY "%s: out of memory; close other programs"
#define gp_no_memory(log, file) gp_fail(log, GP_ERR_BUG, GP_NO_MEMORY, file)
#define gp_no_memory_bare(log, what) \
    gp_fail_bare(log, GP_ERR_BUG, GP_NO_MEMORY, what)

/* gp_say(log, level, fmt, ...) prints a warning or a note; same form, never ends the run.
 * gp_say_at(log, level, parameter, fmt, ...): the same about a parameter. */
#define gp_say(log, level, ...) \
    ((void) gp_print(log, level, GP_OK, "", __VA_ARGS__))
#define gp_say_at(log, level, ...) \
    ((void) gp_print(log, level, GP_OK, __VA_ARGS__))

/* The text of a status; "unknown status" for a number not in the list. */
const char *gp_status_text(gp_status status);

/* Returns the bytes of the UTF-8 sequence at `text`, 0 when it is none
 * (RFC 3629); 1 at the end of the text. */
size_t gp_utf8_bytes(const char *text);

/* Returns the bytes of the control character at `text`, 0 where there is none:
 * C0, DEL and C1 (ECMA-48), these also as single bytes, and those that order
 * text or end lines in Unicode (UAX 9: U+061C, U+200E, U+200F, U+202A to U+202E,
 * U+2066 to U+2069; U+2028, U+2029). */
size_t gp_control_bytes(const char *text);

/* Makes a name of a file, a channel or a library one line that moves no cursor
 * and reads in its own order, in place: tabs and line breaks become spaces,
 * other control characters '?', one for each byte. Names that are not UTF-8
 * keep their other bytes. Every message goes through it. */
void gp_make_printable(char *text);

/* Returns a printable copy of a name, cut at the length of a message's line:
 * printf("%s", gp_printable(name).text). */
struct gp_printable {
    char text[GP_LINE_BYTES];
};
struct gp_printable gp_printable(const char *text);

/* A search for the nearest name: start with gp_nearest_to(), try each name,
 * read `name`. */
struct gp_nearest {
    const char *word;
    size_t length;
    int most;          // edits allowed, then those of `name`
    const char *name;  // the nearest so far, the first of equals; NULL: none
};

/* Starts a search for a word of that many bytes, borrowed; names more than
 * `most` edits away, or half the word's bytes, do not match. */
struct gp_nearest gp_nearest_to(const char *word, size_t length, int most);

/* Tries one name, borrowed. An edit inserts, deletes or replaces a byte, or
 * swaps two neighbours (the optimal string alignment distance). Words and names
 * over 31 bytes do not match. */
void gp_nearest_try(struct gp_nearest *search, const char *name);

/* Runs `expr`; when it fails, jumps to the label `out` with `st` set. */
#define GP_TRY(expr)                                                          \
    do {                                                                      \
        st = (gp_status) (expr);                                              \
        if (st)                                                               \
            goto out;                                                         \
    } while (0)

#endif
