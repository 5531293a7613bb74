/* sun/json: files read strictly, and what their errors say. */
#include "unit.h"
#include "json_file.h"
#include "sun/json.h"

#include <float.h>
#include <locale.h>
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <sys/stat.h>

#include <cmocka.h>

static const struct gp_json_place place = {&jf_log, "a.json", "light", 3};

#define LEN(a) (sizeof(a) / sizeof *(a))
#define BYTES(text) text, sizeof(text) - 1

static void must_say(size_t row, const char *needle)
{
    if (!strstr(jf_line, needle))
        fail_msg("row %zu: \"%s\" lacks \"%s\"", row, jf_line, needle);
}

/* -- files ---------------------------------------------------------------- */

static void files_by_content(void **state)
{
    (void) state;
    static const struct {
        const char *bytes;
        size_t n;
        const char *say; // NULL: read
    } row[] = {
        {BYTES("[]"), NULL},
        {BYTES("{}"), NULL},
        {BYTES(" [1, 2.5, -3e4]\n"), NULL},
        {BYTES("\xef\xbb\xbf[1]"), NULL},
        {BYTES("{\"id\": 18446744073709551615999}"), NULL},
        {BYTES("[\"\xe2\x82\xac\"]"), NULL},
        {BYTES(""), "the file is empty"},
        {BYTES("\n \t\r\n"), "the file is empty"},
        {BYTES("\xef\xbb\xbf"), "the file is empty"},
        {BYTES("3"), "line 1, column 1"},
        {BYTES("[1,\n 2,\n]"), "line 3, column 1"},
        {BYTES("[1] [2]"), "line 1, column 5"},
        {BYTES("{\"a\": 1, \"a\": 2}"), "duplicate"},
        {BYTES("{\"b\": {\"a\": 1, \"a\": 1}}"), "duplicate"},
        {BYTES("[\"\xff\xfe\"]"), "line 1"},
        {BYTES("[\"\xc3(\"]"), "line 1"},
        {BYTES("[\"\xed\xa0\x80\"]"), "line 1"}, // half of a surrogate pair
        {BYTES("[NaN]"), "line 1"},
        {BYTES("[Infinity]"), "line 1"},
        {BYTES("[1e999]"), "overflow"},
        {BYTES("[01]"), "line 1"},
        {BYTES("[1,5.]"), "line 1"},
        {BYTES("[\"a\0b\"]"), "line 1"},
        {BYTES("[1]\0"), "line 1"},
        {BYTES("[\"\\u0000\"]"), "line 1"},
        {BYTES("[\x1b[31m]"), "(invalid token near '?"},
        {BYTES("// no\n[]"), "line 1"},
    };
    for (size_t i = 0; i < LEN(row); i++) {
        json_t *const none = (json_t *) &jf_log;
        json_t *root = none;
        gp_status st = gp_json_read(
            &jf_log, jf_write_bytes(row[i].bytes, row[i].n), &root);
        if (st != (row[i].say ? GP_ERR_DATA : GP_OK))
            fail_msg("row %zu: status %d, \"%s\"", i, st, jf_line);
        if (row[i].say) {
            assert_ptr_equal(root, none);
            must_say(i, row[i].say);
            must_say(i, jf_file);
            must_say(i, "; ");
            assert_null(strchr(jf_line, '\x1b'));
        } else {
            json_decref(root);
        }
    }
}

static void files_that_cannot_be_read(void **state)
{
    (void) state;
    json_t *root;
    assert_int_equal(gp_json_read(&jf_log, jf_folder, &root), GP_ERR_IO);
    must_say(0, "it is a folder");
    assert_int_equal(gp_json_read(&jf_log, "/nowhere/a.json", &root),
                     GP_ERR_IO);
    must_say(1, "/nowhere/a.json: cannot open (No such file");
    assert_int_equal(gp_json_read(&jf_log, "", &root), GP_ERR_IO);
    // no size of its own, no end
    assert_int_equal(gp_json_read(&jf_log, "/dev/zero", &root), GP_ERR_DATA);
    must_say(3, "too large");
    assert_int_equal(gp_json_read(NULL, jf_folder, &root), GP_ERR_IO);
}

/* A file of n bytes: an array of one number in spaces. */
static gp_status read_padded(size_t n, json_t **root)
{
    char *text = malloc(n);
    assert_non_null(text);
    memset(text, ' ', n);
    text[0] = '[';
    text[1] = '1';
    text[n - 1] = ']';
    jf_write_bytes(text, n);
    free(text);
    return gp_json_read(&jf_log, jf_file, root);
}

static void sizes_up_to_the_limit(void **state)
{
    (void) state;
    json_t *root;
    assert_int_equal(read_padded(1 << 20, &root), GP_OK);
    json_decref(root);
    assert_int_equal(gp_json_read_most(&jf_log, jf_file, 4096, &root),
                     GP_ERR_DATA);
    must_say(0, "over 4 KiB");
    assert_int_equal(read_padded((1 << 20) + 1, &root), GP_ERR_DATA);
    must_say(1, "over 1024 KiB");
    assert_int_equal(read_padded(2 << 20, &root), GP_ERR_DATA);
    assert_int_equal(gp_json_read_most(&jf_log, jf_file, 2 << 20, &root),
                     GP_OK);
    json_decref(root);
}

static void deep_nesting_is_an_error(void **state)
{
    (void) state;
    static char text[1 << 19];
    static const char *const open[] = {"[", "{\"a\":"};
    for (size_t i = 0; i < LEN(open); i++) {
        const size_t step = strlen(open[i]);
        size_t n = 0;
        for (; n + step < sizeof text; n += step)
            memcpy(text + n, open[i], step);
        json_t *root;
        assert_int_equal(gp_json_read(&jf_log, jf_write_bytes(text, n), &root),
                         GP_ERR_DATA);
        must_say(i, "depth");
    }
}

static void a_decimal_comma_changes_nothing(void **state)
{
    (void) state;
    static const char *const names[] = {"de_DE.UTF-8", "de_DE.utf8", "de_DE",
                                        "fr_FR.UTF-8"};
    const char *set = NULL;
    for (size_t i = 0; !set && i < LEN(names); i++)
        set = setlocale(LC_ALL, names[i]);
    if (!set)
        skip();
    json_t *root;
    double v = 0.0;
    gp_status st = gp_json_read(&jf_log, jf_write("{\"a\": 1.25}"), &root);
    if (!st) {
        st = gp_json_number(&place, root, "a", 0, 2, &v, NULL);
        json_decref(root);
    }
    setlocale(LC_ALL, "C");
    assert_int_equal(st, GP_OK);
    assert_true(v == 1.25);
}

/* -- structure ------------------------------------------------------------- */

static json_t *object(const char *text)
{
    json_t *o;
    if (gp_json_read(&jf_log, jf_write(text), &o))
        fail_msg("%s: %s", text, jf_line);
    return o;
}

static void arrays_of_files(void **state)
{
    (void) state;
    static const struct {
        const char *text;
        int count; // -1: an error that says
        const char *say;
    } row[] = {
        {"[]", 0, NULL},
        {"[1, 2]", 2, NULL},
        {"{\"items\": [1]}", 1, NULL},
        {"{\"x\": 0, \"items\": [1]}", 1, NULL},
        {"[1, 2, 3, 4]", -1, "found 4); at most 3"},
        {"{\"items\": 3}", -1, "no array (found 3)"},
        {"{\"items\": null}", -1, "no array (found null)"},
        {"{\"Items\": []}", -1, "no \"items\""},
        {"{}", -1, "no \"items\""},
    };
    for (size_t i = 0; i < LEN(row); i++) {
        json_t *root = object(row[i].text), *a = NULL;
        gp_status st = gp_json_array(&place, root, "items", 3, &a);
        assert_int_equal(st, row[i].count < 0 ? GP_ERR_DATA : GP_OK);
        if (row[i].count < 0)
            must_say(i, row[i].say);
        else
            assert_int_equal(json_array_size(a), row[i].count);
        json_decref(root);
    }
}

static void keys_must_be_known(void **state)
{
    (void) state;
    static const char *const keys[] = {"a", "bc", NULL};
    static const char *const none[] = {NULL};
    static const struct {
        const char *text, *say;
    } row[] = {
        {"{}", NULL},
        {"{\"bc\": 0, \"a\": 0}", NULL},
        {"{\"a\": 0, \"b\": 0}",
         "a.json: light 3: unknown key (found \"b\"); there are \"a\", \"bc\""},
        {"{\"z\": 0, \"y\": 0}", "\"z\""}, // the file's first
        {"{\"A\": 0}", "\"A\""},
        {"{\"\": 0}", "(found \"\")"},
        {"{\"\\u001b[2J\\nx\": 0}", "\"?[2J?x\""},
        {"[0, 1]", "no object (found an array of 2)"},
    };
    for (size_t i = 0; i < LEN(row); i++) {
        json_t *root = object(row[i].text);
        gp_status st = gp_json_keys(&place, root, keys);
        assert_int_equal(st, row[i].say ? GP_ERR_DATA : GP_OK);
        if (row[i].say)
            must_say(i, row[i].say);
        json_decref(root);
    }
    json_t *root = object("{\"a\": 0}");
    assert_int_equal(gp_json_keys(&place, root, none), GP_ERR_DATA);
    json_decref(root);
}

/* A name may be as long as the file; a line may not. */
static void long_names_are_cut(void **state)
{
    (void) state;
    static const char *const keys[] = {"a", NULL};
    static char text[4000];
    for (size_t i = 0; i < 2; i++) {
        // two bytes each: a cut falls between them in one of the rows
        int n = snprintf(text, sizeof text, i ? "{\"x" : "{\"");
        while (n < 3900)
            n += snprintf(text + n, sizeof text - (size_t) n, "\xc3\xa4");
        snprintf(text + n, sizeof text - (size_t) n, "\": 0}");
        json_t *root = object(text);
        assert_int_equal(gp_json_keys(&place, root, keys), GP_ERR_DATA);
        assert_true(strlen(jf_line) < 250);
        must_say(i, "\xc3\xa4\"); there are");
        json_decref(root);
    }
}

/* -- values ---------------------------------------------------------------- */

static void numbers_have_ranges(void **state)
{
    (void) state;
    static const struct {
        const char *text;
        double lo, hi, want; // want when say is NULL
        bool found;
        const char *say;
    } row[] = {
        {"{}", 0, 1, -7, false, NULL},
        {"{\"v\": 0}", 0, 1, 0, true, NULL},
        {"{\"v\": 1}", 0, 1, 1, true, NULL},
        {"{\"v\": 2.5e-1}", 0, 1, 0.25, true, NULL},
        {"{\"v\": -1e308}", -DBL_MAX, DBL_MAX, -1e308, true, NULL},
        {"{\"v\": 1.0000001}", 0, 1, 0, true, "(found 1.0000001)"},
        {"{\"v\": -1e-9}", 0, 1, 0, true, "range (found -1e-09); give 0 to 1"},
        {"{\"v\": \"1\"}", 0, 1, 0, true, "no number (found a text)"},
        {"{\"v\": true}", 0, 1, 0, true, "(found true)"},
        {"{\"v\": false}", 0, 1, 0, true, "(found false)"},
        {"{\"v\": null}", 0, 1, 0, true, "(found null)"},
        {"{\"v\": [1]}", 0, 1, 0, true, "(found an array of 1)"},
        {"{\"v\": {}}", -DBL_MAX, DBL_MAX, 0, true, "give a finite number"},
    };
    for (size_t i = 0; i < LEN(row); i++) {
        json_t *o = object(row[i].text);
        double v = -7;
        bool found = !row[i].found;
        gp_status st = gp_json_number(&place, o, "v", row[i].lo, row[i].hi, &v,
                                      &found);
        if (st != (row[i].say ? GP_ERR_DATA : GP_OK))
            fail_msg("row %zu: status %d %s", i, st, jf_line);
        assert_true(v == (row[i].say ? -7 : row[i].want));
        assert_int_equal(found, row[i].found);
        if (row[i].say) {
            must_say(i, row[i].say);
            must_say(i, "a.json: light 3: \"v\"");
        }
        json_decref(o);
    }
}

static void ints_are_whole(void **state)
{
    (void) state;
    static const struct {
        const char *text;
        int want;
        const char *say;
    } row[] = {
        {"{}", 7, NULL},
        {"{\"v\": 3}", 3, NULL},
        {"{\"v\": 4.0}", 4, NULL},
        {"{\"v\": -2147483648}", INT32_MIN, NULL},
        {"{\"v\": 2147483647}", INT32_MAX, NULL},
        {"{\"v\": 2147483648}", 7, "out of range"},
        {"{\"v\": 1e300}", 7, "out of range"},
        {"{\"v\": 3.5}", 7, "no whole number (found 3.5)"},
        {"{\"v\": \"3\"}", 7, "no number"},
    };
    for (size_t i = 0; i < LEN(row); i++) {
        json_t *o = object(row[i].text);
        int v = 7;
        gp_status st =
            gp_json_int(&place, o, "v", INT32_MIN, INT32_MAX, &v, NULL);
        assert_int_equal(st, row[i].say ? GP_ERR_DATA : GP_OK);
        assert_int_equal(v, row[i].want);
        if (row[i].say)
            must_say(i, row[i].say);
        json_decref(o);
    }
}

static void numbers_in_arrays(void **state)
{
    (void) state;
    static const struct {
        const char *text;
        bool grey;
        double want[3];
        const char *say;
    } row[] = {
        {"{}", true, {9, 9, 9}, NULL},
        {"{\"v\": [1, 2, 3]}", false, {1, 2, 3}, NULL},
        {"{\"v\": [1, 2, 3]}", true, {1, 2, 3}, NULL},
        {"{\"v\": 2.5}", true, {2.5, 2.5, 2.5}, NULL},
        {"{\"v\": 2.5}", false, {9, 9, 9}, "3 numbers (found 2.5)"},
        {"{\"v\": []}", true, {9, 9, 9}, "(found an array of 0); give 3 of"},
        {"{\"v\": [1, 2]}", true, {9, 9, 9}, "them, or one"},
        {"{\"v\": [1, 2, 3, 4]}", false, {9, 9, 9}, "an array of 4"},
        {"{\"v\": [1, 2, 11]}", false, {9, 9, 9}, "range (found 11); give 0"},
        {"{\"v\": [1, \"2\", 3]}", false, {9, 9, 9}, "(found a text)"},
        {"{\"v\": {\"0\": 1}}", true, {9, 9, 9}, "(found an object)"},
        {"{\"v\": 11}", true, {9, 9, 9}, "range (found 11)"},
    };
    for (size_t i = 0; i < LEN(row); i++) {
        json_t *o = object(row[i].text);
        double v[3] = {9, 9, 9};
        gp_status st = gp_json_numbers(&place, o, "v", 3, row[i].grey, 0, 10,
                                       v, NULL);
        if (st != (row[i].say ? GP_ERR_DATA : GP_OK))
            fail_msg("row %zu: status %d %s", i, st, jf_line);
        assert_memory_equal(v, row[i].want, sizeof v);
        if (row[i].say)
            must_say(i, row[i].say);
        json_decref(o);
    }
}

static void texts_and_choices(void **state)
{
    (void) state;
    static const char *const names[] = {"disc", "ring", NULL};
    static const struct {
        const char *text;
        gp_status as_text, as_choice;
        int want;
        const char *say; // of the choice
    } row[] = {
        {"{}", GP_OK, GP_OK, 5, NULL},
        {"{\"v\": \"disc\"}", GP_OK, GP_OK, 0, NULL},
        {"{\"v\": \"ring\"}", GP_OK, GP_OK, 1, NULL},
        {"{\"v\": \"rin\"}", GP_OK, GP_ERR_DATA, 5,
         "unknown \"v\" (found \"rin\"); there are \"disc\", \"ring\""},
        {"{\"v\": \"\"}", GP_OK, GP_ERR_DATA, 5, "(found \"\")"},
        {"{\"v\": 1}", GP_ERR_DATA, GP_ERR_DATA, 5, "no text (found 1)"},
    };
    for (size_t i = 0; i < LEN(row); i++) {
        json_t *o = object(row[i].text);
        const char *text = NULL;
        int v = 5;
        assert_int_equal(gp_json_text(&place, o, "v", &text, NULL),
                         row[i].as_text);
        assert_int_equal(gp_json_choice(&place, o, "v", names, &v, NULL),
                         row[i].as_choice);
        assert_int_equal(v, row[i].want);
        if (row[i].say)
            must_say(i, row[i].say);
        json_decref(o);
    }
}

static void the_file_itself_has_no_number(void **state)
{
    (void) state;
    const struct gp_json_place whole = {&jf_log, "a.json", "light", 0};
    json_t *o = object("{\"v\": 3}");
    double v;
    assert_int_equal(gp_json_number(&whole, o, "v", 0, 1, &v, NULL),
                     GP_ERR_DATA);
    assert_string_equal(
        jf_line, "a.json: \"v\" out of range (found 3); give 0 to 1");
    json_decref(o);
}

SUITE(json)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(files_by_content),
        cmocka_unit_test(files_that_cannot_be_read),
        cmocka_unit_test(sizes_up_to_the_limit),
        cmocka_unit_test(deep_nesting_is_an_error),
        cmocka_unit_test(a_decimal_comma_changes_nothing),
        cmocka_unit_test(arrays_of_files),
        cmocka_unit_test(keys_must_be_known),
        cmocka_unit_test(long_names_are_cut),
        cmocka_unit_test(numbers_have_ranges),
        cmocka_unit_test(ints_are_whole),
        cmocka_unit_test(numbers_in_arrays),
        cmocka_unit_test(texts_and_choices),
        cmocka_unit_test(the_file_itself_has_no_number),
    };
    return cmocka_run_group_tests(tests, jf_setup, jf_teardown);
}
