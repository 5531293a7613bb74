#include "app/manual.h"

#include <ctype.h>
#include <string.h>
#include <strings.h>

static const char *next_line(const char *at)
{
    const char *end = strchr(at, '\n');
    return end ? end + 1 : at + strlen(at);
}

static size_t line_size(const char *at)
{
    return strcspn(at, "\n");
}

/* True when the line is the macro `name`, ".Pp". */
static bool is_macro(const char *line, const char *name)
{
    const size_t n = strlen(name);
    return strncmp(line, name, n) == 0 && strchr(" \n", line[n]);
}

// -- sections ----------------------------------------------------------------

static bool is_heading(const char *line)
{
    return is_macro(line, ".Sh") || is_macro(line, ".Ss");
}

/* Those that --help prints, or that hold only the sections below them. */
static bool is_left_out(const char *title, size_t size)
{
    static const char *const names[] = {
        "NAME", "SYNOPSIS", "DESCRIPTION", "OPTIONS", "SEE ALSO",
    };
    for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
        if (strlen(names[i]) == size && strncmp(names[i], title, size) == 0)
            return true;
    }
    return false;
}

bool gp_section_next(const char *at, struct gp_section *out)
{
    for (; *at; at = next_line(at)) {
        if (!is_heading(at) || line_size(at) <= 4)
            continue;
        out->title = at + 4;
        out->title_size = line_size(at) - 4;
        out->text = out->end = next_line(at);
        while (*out->end && !is_heading(out->end))
            out->end = next_line(out->end);
        if (!is_left_out(out->title, out->title_size))
            return true;
    }
    return false;
}

/* The next word of letters in [*at, end): its size, 0 at the end. */
static size_t title_word(const char **at, const char *end)
{
    while (*at < end && !isalpha((unsigned char) **at))
        ++*at;
    size_t n = 0;
    while (*at + n < end && isalpha((unsigned char) (*at)[n]))
        n++;
    return n;
}

void gp_section_word(const struct gp_section *s, char *word, size_t size)
{
    const char *const end = s->title + s->title_size, *at = s->title;
    const char *longest = at;
    size_t n, most = 0;
    for (; (n = title_word(&at, end)); at += n) {
        if (n > most) {
            most = n;
            longest = at;
        }
    }
    most = most < size ? most : size - 1;
    for (size_t i = 0; i < most; i++)
        word[i] = (char) tolower((unsigned char) longest[i]);
    word[most] = '\0';
}

static bool is_word(const char *a, size_t n, const char *b, bool loose)
{
    size_t m = strlen(b);
    n -= loose && n > 1 && tolower((unsigned char) a[n - 1]) == 's';
    m -= loose && m > 1 && tolower((unsigned char) b[m - 1]) == 's';
    return n == m && strncasecmp(a, b, n) == 0;
}

bool gp_section_is(const struct gp_section *s, const char *topic, bool loose)
{
    const char *const end = s->title + s->title_size, *at = s->title;
    size_t n;
    if (is_word(s->title, s->title_size, topic, loose))
        return true;
    for (; (n = title_word(&at, end)); at += n) {
        if (is_word(at, n, topic, loose))
            return true;
    }
    return false;
}

// -- words on lines ----------------------------------------------------------

struct page {
    FILE *f;
    int column;
    int indent;    // of running text
    bool glue;     // the next word follows without a blank
    bool verbatim;
};
enum { WIDTH = 79, BODY = 4, STEP = 4 };

static void break_line(struct page *p)
{
    if (p->column)
        putc('\n', p->f);
    p->column = 0;
    p->glue = false;
}

/* The size of a word without roff's escapes; copies it when `to` is set. */
static int plain(const char *word, size_t n, char *to)
{
    int size = 0;
    for (size_t i = 0; i < n; i++) {
        char c = word[i];
        if (c == '\\' && i + 1 < n) {
            c = word[++i];
            if (c == '&')
                continue;
            c = c == 'e' ? '\\' : c;
        }
        if (to)
            to[size] = c;
        size++;
    }
    return size;
}

static void put(struct page *p, const char *word, size_t n)
{
    char text[256];
    if (n > sizeof text)
        n = sizeof text;
    const int size = plain(word, n, text);
    const bool glue = p->glue || !p->column;
    if (p->column && p->column + size + !glue > WIDTH) {
        putc('\n', p->f);
        p->column = 0;
    }
    if (!p->column)
        p->column = fprintf(p->f, "%*s", p->indent, "");
    else if (!glue)
        p->column += fprintf(p->f, " ");
    p->column += fprintf(p->f, "%.*s", size, text);
    p->glue = false;
}

/* The size of a line's next word; moves *at over blanks to it. */
static size_t next_word(const char **at, const char *end)
{
    while (*at < end && **at == ' ')
        ++*at;
    size_t n = 0;
    while (*at + n < end && (*at)[n] != ' ')
        n++;
    return n;
}

static bool is_punctuation(const char *word, size_t n)
{
    return n == 1 && strchr(".,;:)", *word);
}

/* Which macro a word is, or -1. */
static int find_macro(const char *word, size_t n)
{
    static const char names[][3] = {
        "Fl", "Cm", "Ar", "Pa", "Li", "Ev", "Nm", "Sq", "Pq", "Op",
    };
    for (int i = 0; n == 2 && i < (int) (sizeof names / sizeof *names); i++) {
        if (strncmp(names[i], word, 2) == 0)
            return i;
    }
    return -1;
}
enum { FLAG = 0, NAME = 6, QUOTE, PAREN, OPTIONAL };

/* A line of macros and their words: "Fl \-fft-plan Cm measure ,". */
static void put_macros(struct page *p, const char *at, const char *end)
{
    static const char marks[][2] = {"'", "'", "(", ")", "[", "]"};
    const char *closing = NULL;
    bool flag = false, tail = false;
    size_t n;
    for (; (n = next_word(&at, end)); at += n) {
        const int macro = find_macro(at, n);
        if (macro >= 0)
            flag = macro == FLAG;
        if (macro == NAME)
            put(p, "glarepp", 7);
        if (macro >= QUOTE) {
            put(p, marks[2 * (macro - QUOTE)], 1);
            closing = marks[2 * (macro - QUOTE) + 1];
            p->glue = true;
        }
        if (macro >= 0)
            continue;
        tail = is_punctuation(at, n);
        if (tail && closing && at + n == end) {
            p->glue = true;
            put(p, closing, 1);
            closing = NULL;
        }
        p->glue = p->glue || tail;
        if (flag && !tail) {
            put(p, "-", 1);
            p->glue = true;
        }
        put(p, at, n);
    }
    if (closing) {
        p->glue = true;
        put(p, closing, 1);
    }
}

static void put_words(struct page *p, const char *at, const char *end)
{
    size_t n;
    for (; (n = next_word(&at, end)); at += n)
        put(p, at, n);
}

// -- lines -------------------------------------------------------------------

static void put_verbatim(struct page *p, const char *at, const char *end)
{
    break_line(p);
    fprintf(p->f, "%*s", p->indent + STEP, "");
    while (at < end) {
        char text[256];
        const size_t n = (size_t) (end - at) < sizeof text
                             ? (size_t) (end - at) : sizeof text;
        fprintf(p->f, "%.*s", plain(at, n, text), text);
        at += n;
    }
    putc('\n', p->f);
}

static void put_item(struct page *p, const char *at, const char *end)
{
    break_line(p);
    p->indent -= STEP;
    // a head of plain words has no macro: "70"
    put_macros(p, at, end);
    p->indent += STEP;
    break_line(p);
}

/* A line of blocks; false when it is one of running text. */
static bool put_block(struct page *p, const char *line, const char *end)
{
    if (is_macro(line, ".Ed")) {
        p->verbatim = false;
    } else if (p->verbatim) {
        put_verbatim(p, line, end);
    } else if (is_macro(line, ".Bd")) {
        break_line(p);
        p->verbatim = true;
    } else if (is_macro(line, ".Pp")) {
        break_line(p);
        putc('\n', p->f);
    } else if (is_macro(line, ".Bl")) {
        p->indent += STEP;
    } else if (is_macro(line, ".El")) {
        break_line(p);
        p->indent -= STEP;
    } else if (is_macro(line, ".It")) {
        put_item(p, line + 3, end);
    } else if (is_macro(line, ".Dl")) {
        put_verbatim(p, line + 4, end);
    } else {
        return false;
    }
    return true;
}

// NOLINTNEXTLINE(misc-no-recursion): one deep, for a part has no parts
static void put_lines(struct page *p, const char *at, const char *end,
                      const char *parts)
{
    for (; at < end; at = next_line(at)) {
        const size_t n = line_size(at);
        if (*at == '@' && parts) {
            const char *part = parts;
            while (*part && strncmp(part, at, n + 1) != 0) // with its newline
                part = next_line(part);
            const char *from = next_line(part), *to = from;
            while (*to && *to != '@')
                to = next_line(to);
            put_lines(p, from, to, NULL);
        } else if (put_block(p, at, at + n) || strncmp(at, ".\\\"", 3) == 0) {
            continue;
        } else if (*at == '.') {
            put_macros(p, at + 1, at + n);
        } else {
            put_words(p, at, at + n);
        }
    }
}

void gp_section_print(FILE *f, const struct gp_section *s, const char *parts)
{
    struct page p = {.f = f, .indent = BODY};
    fprintf(f, "%.*s\n", (int) s->title_size, s->title);
    put_lines(&p, s->text, s->end, parts);
    break_line(&p);
}
