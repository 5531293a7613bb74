// SPDX-License-Identifier: Apache-2.0
/* core/json: files read strictly, and what their errors say. */
#include "unit.h"
#include "json_file.h"
#include "core/json.h"

#include <float.h>
#include <locale.h>

static const struct gp_json_place place = {&kept_log, "a.json", "light", 3};

#define BYTES(text) text, sizeof(text) - 1

static void must_say(size_t row, const char *needle)
{
    if (!strstr(kept_line, needle))
        fail_msg("row %zu: \"%s\" lacks \"%s\"", row, kept_line, needle);
}

static gp_status read_small(const char *path, json_t **root)
{
    return gp_json_read(&kept_log, path, GP_JSON_SMALL, root);
}

/* -- files ---------------------------------------------------------------- */

static void files_by_content(void **state)
{
    static const struct {
        const char *bytes;
        size_t n;
        const char *say; // NULL: read
    } row[] = {
        {BYTES("[]"), NULL}, {BYTES("{}"), NULL},
        {BYTES(" [1, 2.5, -3e4]\n"), NULL}, {BYTES("\xef\xbb\xbf[1]"), NULL},
        {BYTES("{\"id\": 18446744073709551615999}"), NULL},
        {BYTES("[\"\xe2\x82\xac\"]"), NULL}, {BYTES(""), "the file is empty"},
        {BYTES("\n \t\r\n"), "the file is empty"},
        {BYTES("\xef\xbb\xbf"), "the file is empty"},
        {BYTES("3"), "line 1, column 1"},
        {BYTES("[1,\n 2,\n]"), "line 3, column 1"},
        {BYTES("[1] [2]"), "line 1, column 5"},
        {BYTES("{\"a\": 1, \"a\": 2}"), "duplicate"},
        {BYTES("{\"b\": {\"a\": 1, \"a\": 1}}"), "duplicate"},
        {BYTES("[\"\xff\xfe\"]"), "line 1"}, {BYTES("[\"\xc3(\"]"), "line 1"},
        {BYTES("[\"\xed\xa0\x80\"]"), "line 1"}, // half of a surrogate pair
        {BYTES("[NaN]"), "line 1"}, {BYTES("[Infinity]"), "line 1"},
        {BYTES("[1e999]"), "overflow"}, {BYTES("[01]"), "line 1"},
        {BYTES("[1,5.]"), "line 1"}, {BYTES("[\"a\0b\"]"), "line 1"},
        {BYTES("[1]\0"), "line 1"}, {BYTES("[\"\\u0000\"]"), "line 1"},
        {BYTES("[\x1b[31m]"), "(invalid token near '?"},
        {BYTES("// no\n[]"), "line 1"},
    };
    for (size_t i = 0; i < COUNT(row); i++) {
        json_t *const none = (json_t *) &kept_log;
        json_t *root = none;
        gp_status st =
            read_small(jf_write_bytes(row[i].bytes, row[i].n), &root);
        if (st != (row[i].say ? GP_ERR_DATA : GP_OK))
            fail_msg("row %zu: status %d, \"%s\"", i, st, kept_line);
        if (row[i].say) {
            assert_ptr_equal(root, none);
            must_say(i, row[i].say);
            must_say(i, path);
            must_say(i, "; ");
            assert_null(strchr(kept_line, '\x1b'));
        } else {
            json_decref(root);
        }
    }
}

static void files_that_cannot_be_read(void **state)
{
    json_t *root;
    assert_int_equal(read_small(folder, &root), GP_ERR_IO);
    must_say(0, folder);
    assert_int_equal(read_small("/nowhere/a.json", &root), GP_ERR_IO);
    must_say(1, "/nowhere/a.json: ");
    assert_int_equal(read_small("", &root), GP_ERR_IO);
    // it has no end
    assert_int_equal(read_small("/dev/zero", &root), GP_ERR_DATA);
    must_say(3, "no regular file");
    assert_int_equal(gp_json_read(NULL, folder, GP_JSON_SMALL, &root),
                     GP_ERR_IO);
}

/* A file of n bytes: an array of one number in spaces. */
static gp_status read_padded(size_t n, size_t most)
{
    char *text = malloc(n);
    json_t *root;
    assert_non_null(text);
    memset(text, ' ', n);
    text[0] = '[';
    text[1] = '1';
    text[n - 1] = ']';
    gp_status st = gp_json_read(&kept_log, jf_write_bytes(text, n), most, &root);
    free(text);
    if (!st)
        json_decref(root);
    return st;
}

static void sizes_up_to_the_limit(void **state)
{
    assert_ok(read_padded(1 << 20, 1 << 20));
    assert_int_equal(read_padded(1 << 20, 4096), GP_ERR_DATA);
    must_say(0, "over 4 KiB");
    assert_int_equal(read_padded((1 << 20) + 1, 1 << 20), GP_ERR_DATA);
    assert_int_equal(read_padded(2 << 20, 1 << 20), GP_ERR_DATA);
    assert_ok(read_padded(2 << 20, 2 << 20));
}

static void deep_nesting_is_an_error(void **state)
{
    static char text[1 << 19];
    static const char *const open[] = {"[", "{\"a\":"};
    for (size_t i = 0; i < COUNT(open); i++) {
        const size_t step = strlen(open[i]);
        size_t n = 0;
        json_t *root;
        for (; n + step < sizeof text; n += step)
            memcpy(text + n, open[i], step);
        assert_int_equal(read_small(jf_write_bytes(text, n), &root),
                         GP_ERR_DATA);
        must_say(i, "depth");
    }
}

static json_t *object(const char *text)
{
    json_t *o;
    if (read_small(jf_write(text), &o))
        fail_msg("%s: %s", text, kept_line);
    return o;
}

static void a_decimal_comma_changes_nothing(void **state)
{
    static const char *const names[] = {"de_DE.UTF-8", "de_DE.utf8", "de_DE",
                                        "fr_FR.UTF-8"};
    const char *set = NULL;
    for (size_t i = 0; !set && i < COUNT(names); i++)
        set = setlocale(LC_ALL, names[i]);
    if (!set)
        skip_for("no locale with a decimal comma");
    double v = 0.0;
    json_t *o = object("{'a': 1.25}");
    assert_ok(gp_json_number(&place, o, "a", 0, 2, &v));
    json_decref(o);
    setlocale(LC_ALL, "C");
    assert_true(v == 1.25);
}

/* -- structure ------------------------------------------------------------- */

/* Arrays by the name "items", of at most three; and known keys. */
static void arrays_and_keys(void **state)
{
    enum { KEYS = -1 };
    static const char *const keys[] = {"a", "bc", NULL};
    static const struct {
        const char *text;
        int count; // of the array
        const char *say;
    } row[] = {
        {"[]", 0, NULL}, {"[1, 2]", 2, NULL}, {"{'items': [1]}", 1, NULL},
        {"{'x': 0, 'items': [1]}", 1, NULL}, {"{}", 0, "\"items\""},
        {"[1, 2, 3, 4]", 0, "\"items\""}, {"{'items': 3}", 0, "\"items\""},
        {"{'items': null}", 0, "\"items\""}, {"{'Items': []}", 0, "\"items\""},
        {"{}", KEYS, NULL}, {"{'bc': 0, 'a': 0}", KEYS, NULL},
        {"{'a': 0, 'b': 0}", KEYS, "a.json: light 3: "},
        {"{'z': 0, 'y': 0}", KEYS, "\"z\""}, // the file's first
        {"{'A': 0}", KEYS, "\"A\""}, {"{'': 0}", KEYS, "(found \"\")"},
        {"{'\\u001b[2J\\nx': 0}", KEYS, "\"?[2J x\""},
        {"[0, 1]", KEYS, "(found an array of 2)"},
    };
    for (size_t i = 0; i < COUNT(row); i++) {
        json_t *root = object(row[i].text), *a = NULL;
        gp_status st = row[i].count == KEYS
                           ? gp_json_keys(&place, root, keys)
                           : gp_json_array(&place, root, "items", 3, &a);
        assert_int_equal(st, row[i].say ? GP_ERR_DATA : GP_OK);
        if (row[i].say)
            must_say(i, row[i].say);
        else if (row[i].count != KEYS)
            assert_int_equal(json_array_size(a), row[i].count);
        json_decref(root);
    }
}

/* A name may be as long as the file; a line may not. */
static void long_names_are_cut(void **state)
{
    static const char *const keys[] = {"a", NULL};
    static char text[4000];
    for (size_t i = 0; i < 2; i++) {
        // two bytes each: a cut falls between them in one of the rows
        int n = snprintf(text, sizeof text, i ? "{'x" : "{'");
        while (n < 3900)
            n += snprintf(text + n, sizeof text - (size_t) n, "\xc3\xa4");
        snprintf(text + n, sizeof text - (size_t) n, "': 0}");
        json_t *root = object(text);
        assert_int_equal(gp_json_keys(&place, root, keys), GP_ERR_DATA);
        assert_true(strlen(kept_line) < 250);
        must_say(i, "\xc3\xa4\"); use one of");
        json_decref(root);
    }
}

enum kind { NUMBER, INT, ARRAY, GREY, TEXT, CHOICE };

/* Value "v" of an object as each kind: numbers in [lo, hi], three of
 * them in an array, one of "disc" and "ring". Where it is an error or missing,
 * what was there stays. */
static void values(void **state)
{
    static const char *const names[] = {"disc", "ring", NULL};
    static const struct {
        enum kind kind;
        const char *text;
        double lo, hi, want[3];
        const char *say; // NULL: no error
    } row[] = {
        {NUMBER, "{}", 0, 1, {9}, NULL}, {NUMBER, "{'v': 0}", 0, 1, {0}, NULL},
        {NUMBER, "{'v': 1}", 0, 1, {1}, NULL},
        {NUMBER, "{'v': 2.5e-1}", 0, 1, {0.25}, NULL},
        {NUMBER, "{'v': -1e308}", -DBL_MAX, DBL_MAX, {-1e308}, NULL},
        {NUMBER, "{'v': 1.0000001}", 0, 1, {9}, "(found 1.0000001)"},
        {NUMBER, "{'v': -1e-9}", 0, 1, {9}, "(found -1e-09); give 0 to 1"},
        {NUMBER, "{'v': '1'}", 0, 1, {9}, "(found a string)"},
        {NUMBER, "{'v': true}", 0, 1, {9}, "(found true)"},
        {NUMBER, "{'v': false}", 0, 1, {9}, "(found false)"},
        {NUMBER, "{'v': null}", 0, 1, {9}, "(found null)"},
        {NUMBER, "{'v': [1]}", 0, 1, {9}, "(found an array of 1)"},
        {NUMBER, "{'v': {}}", -DBL_MAX, DBL_MAX, {9}, "a finite number"},
        {INT, "{}", INT32_MIN, INT32_MAX, {9}, NULL},
        {INT, "{'v': 3}", INT32_MIN, INT32_MAX, {3}, NULL},
        {INT, "{'v': 4.0}", INT32_MIN, INT32_MAX, {4}, NULL},
        {INT, "{'v': -2147483648}", INT32_MIN, INT32_MAX, {INT32_MIN}, NULL},
        {INT, "{'v': 2147483647}", INT32_MIN, INT32_MAX, {INT32_MAX}, NULL},
        {INT, "{'v': 2147483648}", INT32_MIN, INT32_MAX, {9}, "range"},
        {INT, "{'v': 1e300}", INT32_MIN, INT32_MAX, {9}, "range"},
        {INT, "{'v': 3.5}", INT32_MIN, INT32_MAX, {9}, "(found 3.5)"},
        {INT, "{'v': '3'}", INT32_MIN, INT32_MAX, {9}, "not a number"},
        {GREY, "{}", 0, 10, {9, 9, 9}, NULL},
        {ARRAY, "{'v': [1, 2, 3]}", 0, 10, {1, 2, 3}, NULL},
        {GREY, "{'v': [1, 2, 3]}", 0, 10, {1, 2, 3}, NULL},
        {GREY, "{'v': 2.5}", 0, 10, {2.5, 2.5, 2.5}, NULL},
        {ARRAY, "{'v': 2.5}", 0, 10, {9, 9, 9}, "(found 2.5)"},
        {GREY, "{'v': []}", 0, 10, {9, 9, 9}, "(found an array of 0)"},
        {GREY, "{'v': [1, 2]}", 0, 10, {9, 9, 9}, ", or one"},
        {ARRAY, "{'v': [1, 2, 3, 4]}", 0, 10, {9, 9, 9}, "array of 4"},
        {ARRAY, "{'v': [1, 2, 11]}", 0, 10, {9, 9, 9}, "(found 11)"},
        {ARRAY, "{'v': [1, '2', 3]}", 0, 10, {9, 9, 9}, "(found a string)"},
        {GREY, "{'v': {'0': 1}}", 0, 10, {9, 9, 9}, "(found an object)"},
        {GREY, "{'v': 11}", 0, 10, {9, 9, 9}, "(found 11)"},
        {TEXT, "{}", 0, 0, {9}, NULL}, {TEXT, "{'v': ''}", 0, 0, {0}, NULL},
        {TEXT, "{'v': 'ring'}", 0, 0, {4}, NULL},
        {TEXT, "{'v': 1}", 0, 0, {9}, "(found 1)"},
        {CHOICE, "{}", 0, 0, {9}, NULL},
        {CHOICE, "{'v': 'disc'}", 0, 0, {0}, NULL},
        {CHOICE, "{'v': 'ring'}", 0, 0, {1}, NULL},
        {CHOICE, "{'v': 'rin'}", 0, 0, {9}, "use one of \"disc\", \"ring\""},
        {CHOICE, "{'v': ''}", 0, 0, {9}, "(found \"\")"},
        {CHOICE, "{'v': 1}", 0, 0, {9}, "(found 1)"},
    };
    for (size_t i = 0; i < COUNT(row); i++) {
        json_t *o = object(row[i].text);
        double v[3] = {9, 9, 9};
        const char *text = NULL;
        int whole = 9;
        gp_status st = GP_OK;
        if (row[i].kind == NUMBER)
            st = gp_json_number(&place, o, "v", row[i].lo, row[i].hi, v);
        else if (row[i].kind == INT)
            st = gp_json_int(&place, o, "v", INT32_MIN, INT32_MAX, &whole);
        else if (row[i].kind == TEXT)
            st = gp_json_text(&place, o, "v", &text);
        else if (row[i].kind == CHOICE)
            st = gp_json_choice(&place, o, "v", names, &whole);
        else
            st = gp_json_numbers(&place, o, "v", row[i].kind == GREY ? -3 : 3,
                                 row[i].lo, row[i].hi, v);
        if (row[i].kind == INT || row[i].kind == CHOICE)
            v[0] = whole;
        if (row[i].kind == TEXT && text)
            v[0] = (double) strlen(text);
        if (st != (row[i].say ? GP_ERR_DATA : GP_OK))
            fail_msg("row %zu: status %d %s", i, st, kept_line);
        for (int k = 0; k < (row[i].kind == ARRAY ||
                             row[i].kind == GREY ? 3 : 1); k++)
            assert_true(v[k] == row[i].want[k]);
        if (row[i].say) {
            must_say(i, "a.json: light 3: ");
            must_say(i, row[i].say);
        }
        json_decref(o);
    }
}

static void files_without_a_number(void **state)
{
    const struct gp_json_place whole = {&kept_log, "a.json", "light", 0};
    json_t *o = object("{'v': 3}");
    double v;
    assert_int_equal(gp_json_number(&whole, o, "v", 0, 1, &v), GP_ERR_DATA);
    must_say(0, "a.json: \"v\"");
    json_decref(o);
}

/* Values are counted, and no bracket within a string. */
static void memory_is_of_values(void **state)
{
    static const char one[] = "{\"a\": \"[{,:\\\"[{\\\\\"}",
                      two[] = "{\"a\": [{}, []]}";
    (void) state;
    assert_int_equal(gp_json_memory(one, sizeof one - 1),
                     sizeof one - 1 + 210 + 4 * 24 + 40);
    assert_int_equal(gp_json_memory(two, sizeof two - 1),
                     sizeof two - 1 + 2 * 210 + 2 * 120 + 2 * 24 + 2 * 40);
}

SUITE_OF(json, make_folder, remove_folder, files_by_content,
         files_that_cannot_be_read, sizes_up_to_the_limit,
         deep_nesting_is_an_error, a_decimal_comma_changes_nothing,
         arrays_and_keys, long_names_are_cut, values, files_without_a_number,
         memory_is_of_values)
