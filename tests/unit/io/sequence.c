// SPDX-License-Identifier: Apache-2.0
/* io/sequence: patterns, lists of frames, and what is on disk. */
#include "unit.h"
#include "io/sequence.h"
#include "reading.h"

static const struct name_row {
    const char *path;
    int frame;
    const char *name;  // NULL: a usage error
} names[] = {
    {"shot.####.exr", 7, "shot.0007.exr"},
    {"shot.####.exr", 12345, "shot.12345.exr"},
    {"shot.####.exr", -5, "shot.-005.exr"},
    {"shot.#.exr", 1001, "shot.1001.exr"}, {"shot.@.exr", 7, "shot.7.exr"},
    {"shot.@@@.exr", 7, "shot.007.exr"}, {"shot.%d.exr", 7, "shot.7.exr"},
    {"shot.%04d.exr", 7, "shot.0007.exr"},
    {"shot.%09d.exr", 7, "shot.000000007.exr"}, {"####", 1, "0001"},
    {"render@2x.####.png", 3, "render@2x.0003.png"},
    {"render@2x#1.%02d.png", 3, "render@2x#1.03.png"},
    {"a@b/c#d/%d/shot.exr", 3, "a@b/c#d/%d/shot.exr"},
    {"a@b/shot.#.exr", 3, "a@b/shot.3.exr"}, {"plain.exr", 3, "plain.exr"},
    {"100%.exr", 3, "100%.exr"}, {"50%0.exr", 3, "50%0.exr"},
    {"%00d.exr", 3, "%00d.exr"}, {"%4d.exr", 3, "%4d.exr"},
    {"%s%n.exr", 3, "%s%n.exr"}, {"", 3, ""}, {"-", 3, "-"},
    {"a.#.#.exr", 3, NULL}, {"a.%d.%04d.exr", 3, NULL},
    {"a.##########.exr", 3, NULL}, {"a.%099999999999999d.exr", 3, NULL},
};

static void names_of_frames(void **state)
{
    for (size_t i = 0; i < COUNT(names); i++) {
        const struct name_row *r = &names[i];
        struct gp_pattern p;
        gp_status st = gp_pattern_find(NULL, r->path, &p);
        if (!r->name) {
            if (st != GP_ERR_USAGE)
                fail_msg("%s: status %d", r->path, st);
            continue;
        }
        assert_ok(st);
        char *name = gp_pattern_name(&p, r->frame, NULL);
        assert_string_equal(name, r->name);
        free(name);
    }
}

static const struct view_row {
    const char *path, *view;
    int places;
    const char *name;  // of frame 7
} view_names[] = {
    {"shot.%V.####.exr", "left", 1, "shot.left.0007.exr"},
    {"shot.%v.####.exr", "left", 1, "shot.l.0007.exr"},
    {"%V/shot.####.exr", "right", 1, "right/shot.0007.exr"},
    {"%V/%v/%V_%v.%04d.exr", "right", 4, "right/r/right_r.0007.exr"},
    {"%V/x%V#%v.exr", "a#@%d", 3, "a#@%d/xa#@%d7a.exr"},
    {"%V.exr", "%V", 1, "%V.exr"},
    {"%V.exr", "\xc3\xa9t\xc3\xa9", 1, "\xc3\xa9t\xc3\xa9.exr"},
    {"%v.exr", "\xc3\xa9t\xc3\xa9", 1, "\xc3\xa9.exr"},
    {"%v.exr", "l", 1, "l.exr"}, {"%%V.exr", "left", 1, "%left.exr"},
    {"%V%v.exr", "", 2, ".exr"}, {"%V", "left", 1, "left"},
    {"%", "left", 0, "%"}, {"100%", "left", 0, "100%"},
    {"%W%w.exr", "left", 0, "%W%w.exr"}, {"V/v.#.exr", "left", 0, "V/v.7.exr"},
    {"%V.####.exr", NULL, 1, "%V.0007.exr"},
    {"%v/plain.exr", NULL, 1, "%v/plain.exr"},
};

static void names_of_views(void **state)
{
    for (size_t i = 0; i < COUNT(view_names); i++) {
        const struct view_row *r = &view_names[i];
        struct gp_pattern p;
        assert_ok(gp_pattern_find(NULL, r->path, &p));
        assert_int_equal(p.views, r->places);
        char *name = gp_pattern_name(&p, 7, r->view);
        assert_string_equal(name, r->name);
        free(name);
    }
    // a file that has the very name is found by no search, and stays as it is
    const struct gp_pattern literal = {.path = "%V.exr"};
    char *name = gp_pattern_name(&literal, 7, "left");
    assert_string_equal(name, "%V.exr");
    free(name);
}

static const struct view_list_row {
    const char *text, *names;  // NULL: a usage error
} view_lists[] = {
    {"left,right", "left|right"}, {"left", "left"},
    {"right,left,mono", "right|left|mono"}, {" left , right", " left | right"},
    {"left,Left", "left|Left"}, {"a%V,.,-", "a%V|.|-"}, {"", NULL},
    {",", NULL}, {"left,", NULL}, {",left", NULL}, {"left,,right", NULL},
    {"left,right,left", NULL}, {"left,a/b", NULL}, {"/", NULL},
};

static void lists_of_views(void **state)
{
    for (size_t i = 0; i < COUNT(view_lists); i++) {
        const struct view_list_row *r = &view_lists[i];
        struct gp_views v = {0};
        gp_status st = gp_views_parse(NULL, r->text, &v);
        if (!r->names) {
            if (st != GP_ERR_USAGE || v.n)
                fail_msg("\"%s\": status %d", r->text, st);
            continue;
        }
        assert_ok(st);
        char got[256] = "";
        for (int k = 0; k < v.n; k++)
            snprintf(got + strlen(got), sizeof got - strlen(got), "%s%s",
                     k ? "|" : "", v.name[k]);
        assert_string_equal(got, r->names);
        gp_views_free(&v);
        gp_views_free(&v);
    }
}

static const struct alike_row {
    const char *path, *views;
    bool fine;
} alike[] = {
    {"%v.exr", "left,right", true}, {"%v.exr", "left,lefty", false},
    {"%v/%v.exr", "a,b,c,ab", false}, {"%v/%V.exr", "left,lefty", true},
    {"%V.exr", "left,lefty", true}, {"plain.exr", "left,lefty", true},
    {"%v.exr", "left", true},
    {"%v.exr", "\xc3\xa9,\xc3\xa8", true},  // one first byte, two letters
    {"%v.exr", "\xc3\xa9,\xc3\xa9t", false},
};

static void views_of_one_letter(void **state)
{
    for (size_t i = 0; i < COUNT(alike); i++) {
        struct gp_pattern p;
        struct gp_views v;
        assert_ok(gp_pattern_find(NULL, alike[i].path, &p));
        assert_ok(gp_views_parse(NULL, alike[i].views, &v));
        if (gp_views_check(NULL, &p, &v) !=
            (alike[i].fine ? GP_OK : GP_ERR_USAGE))
            fail_msg("%s for %s", alike[i].path, alike[i].views);
        gp_views_free(&v);
    }
}

/* The numbers of a list with blanks between them. */
static const char *numbers_of(const struct gp_frames *f)
{
    static char text[256];
    text[0] = '\0';
    for (int k = 0; k < f->n; k++)
        snprintf(text + strlen(text), sizeof text - strlen(text), "%s%d",
                 k ? " " : "", f->number[k]);
    return text;
}

static const struct list_row {
    const char *text;
    const char *frames;  // NULL: a usage error
} lists[] = {
    {"7", "7"}, {"1-5", "1 2 3 4 5"}, {"5-1", "5 4 3 2 1"},
    {"1-10x4", "1 5 9"}, {"10-1x3", "10 7 4 1"},
    {"3,4,10-20x5", "3 4 10 15 20"}, {"7-20:5,9-6:3", "7 12 17 9 6"},
    {"10-1:-3", "10 7 4 1"}, {"3-3", "3"}, {"3-4x9", "3"},
    {"0007", "7"}, {"-2-1", "-2 -1 0 1"}, {"-2--4", "-2 -3 -4"},
    {"1-3,2-5,1", "1 2 3 4 5"}, {"5,1,5,1", "5 1"},
    {"2,-1,2,-3--1,0", "2 -1 -3 -2 0"},
    {"999999999", "999999999"}, {"", NULL}, {",", NULL}, {"1,", NULL},
    {"1,,2", NULL}, {"1-", NULL}, {"-", NULL}, {"1-5x", NULL}, {"1-5x0", NULL},
    {"1-5x-1", NULL}, {"1-5:", NULL}, {"1-5:-2", NULL}, {"5-1x-2", NULL},
    {"1-5:2x2", NULL}, {"1-5x2x3", NULL}, {" 1", "1"},
    {"1 - 5:2", "1 3 5"}, {"1-5: 2 ,\t9 ", "1 3 5 9"}, {"5 - -1 : -3", "5 2 -1"},
    {"1 2", NULL}, {"- 1", NULL}, {" ", NULL}, {"1 -", NULL}, {"1\n", NULL},
    {"1..5", NULL}, {"a", NULL}, {"+1", NULL}, {"1.5", NULL}, {"1x2", NULL},
    {"1000000000", NULL}, {"99999999999999999999", NULL},
    {"1-999999999", NULL}, {"-999999999-999999999x1", NULL},
    {"1-1000000,2000000", NULL},
};

static void lists_of_frames(void **state)
{
    for (size_t i = 0; i < COUNT(lists); i++) {
        const struct list_row *r = &lists[i];
        struct gp_frames f = {0};
        gp_status st = gp_frames_parse(NULL, r->text, &f);
        if (!r->frames) {
            if (st != GP_ERR_USAGE || f.number)
                fail_msg("\"%s\": status %d", r->text, st);
            continue;
        }
        assert_ok(st);
        assert_string_equal(numbers_of(&f), r->frames);
        gp_frames_free(&f);
        gp_frames_free(&f);
    }
}

/* The longest list there may be is made, and in short time. */
static void longest_list(void **state)
{
    struct gp_frames f = {0};
    assert_ok(gp_frames_parse(NULL, "1000000-1", &f));
    assert_int_equal(f.n, GP_FRAME_LIST_MAX);
    assert_int_equal(f.number[0], 1000000);
    assert_int_equal(f.number[f.n - 1], 1);
    gp_frames_free(&f);
}

static const struct join_row {
    const char *a, *b, *all;
} joins[] = {
    {"1-3", "2-5", "1 2 3 4 5"}, {"9,1", "5", "1 5 9"},
    {"7", "7", "7"},             {"-1", "-3-1", "-3 -2 -1 0 1"},
};

static void frames_together(void **state)
{
    for (size_t i = 0; i < COUNT(joins); i++) {
        struct gp_frames a, b, none = {0};
        assert_ok(gp_frames_parse(NULL, joins[i].a, &a));
        assert_ok(gp_frames_parse(NULL, joins[i].b, &b));
        assert_true(gp_frames_join(&a, &b));
        assert_true(gp_frames_join(&a, &none));
        assert_true(gp_frames_join(&none, &a));
        assert_int_equal(none.n, a.n);
        assert_string_equal(numbers_of(&none), joins[i].all);
        gp_frames_free(&a);
        gp_frames_free(&b);
        gp_frames_free(&none);
    }
    struct gp_frames a = {0}, none = {0};
    assert_true(gp_frames_join(&a, &none));
    assert_int_equal(a.n, 0);
    gp_frames_free(&a);
}

static const char *const files[] = {
    "s.0001.exr", "s.0010.exr", "s.0002.exr", "s.12345.exr", "s.7.exr",
    "s.007.exr", "s.0003.exr.bak", "s.0004.png", "s.-005.exr", "s.00a1.exr",
    "xs.0006.exr", "s..exr", "s.0000000000008.exr", "t9", "s.left.0004.exr",
    "s.left.0006.exr", "s.r.0004.exr", "s.%V.0005.exr",
};

static const struct disk_row {
    const char *pattern, *frames;  // NULL: GP_ERR_IO
    const char *view;
} on_disk[] = {
    {"s.####.exr", "1 2 10 12345", NULL},
    {"s.####.exr", "1 2 10 12345", "left"}, {"s.%V.####.exr", "4 6", "left"},
    {"s.%v.####.exr", "4", "right"}, {"s.%V.####.exr", NULL, "mono"},
    {"s.%V.####.exr", "5", NULL}, {"../%V/s.%v.####.exr", NULL, "right"},
    {"s.%04d.exr", "1 2 10 12345", NULL}, {"s.@.exr", "7 12345", NULL},
    {"s.###.exr", "7 12345", NULL}, {"t#", "9", NULL},
    {"s.####.tif", NULL, NULL}, {"none/s.####.exr", NULL, NULL},
    {"t9/s.####.exr", NULL, NULL},
};

static void frames_that_exist(void **state)
{
    struct gp_pattern p;
    struct gp_frames f = {0};
    for (size_t i = 0; i < COUNT(files); i++) {
        snprintf(path, sizeof path, "%s/%s", folder, files[i]);
        FILE *const file = fopen(path, "w");
        assert_true(file && fclose(file) == 0);
    }
    for (size_t i = 0; i < COUNT(on_disk); i++) {
        const struct disk_row *r = &on_disk[i];
        snprintf(path, sizeof path, "%s/%s", folder, r->pattern);
        assert_ok(gp_pattern_find(NULL, path, &p));
        assert_int_equal(gp_frames_on_disk(NULL, &p, r->view, &f),
                         r->frames ? GP_OK : GP_ERR_IO);
        assert_string_equal(numbers_of(&f), r->frames ? r->frames : "");
        gp_frames_free(&f);
    }
    // the view is the folder
    assert_ok(gp_pattern_find(NULL, "/tmp/%V/s.####.exr", &p));
    assert_ok(gp_frames_on_disk(NULL, &p, folder + 5, &f));
    assert_string_equal(numbers_of(&f), "1 2 10 12345");
    gp_frames_free(&f);
}

static const struct number_row {
    const char *path;
    int frame;  // -1: none
} numbers[] = {
    {"shot.1001.exr", 1001},   {"shot_v2.1001.exr", 1001},
    {"a/7/shot.exr", -1},      {"a/7/shot0012.exr", 12},
    {"shot.1001", 1001},       {"1001.exr", 1001},
    {"1001", 1001},            {"shot1001b.exr", 1001},
    {"shot.exr", -1},          {"", -1}, {"-", -1},                 {".5", 5},
    {"a.mp4", -1},             {"a1.mp4", 1},
    {"x1234567890.exr", -1},   {"x999999999.exr", 999999999},
};

static void numbers_in_names(void **state)
{
    for (size_t i = 0; i < COUNT(numbers); i++) {
        int frame = -1;
        bool found = gp_frame_number(numbers[i].path, &frame);
        if (found != (numbers[i].frame >= 0) || frame != numbers[i].frame)
            fail_msg("%s: %d", numbers[i].path, frame);
    }
}

SUITE_OF(sequence, make_folder, remove_folder, names_of_frames, names_of_views,
         lists_of_views, views_of_one_letter, lists_of_frames, longest_list,
         frames_together, frames_that_exist, numbers_in_names)
