// SPDX-License-Identifier: Apache-2.0
/* core's small files: messages, JSON's text, the program's other files,
 * planes. */
#include "unit.h"
#include "core/murmur.h"
#include "core/bridge.h"
#include "core/image.h"
#include "core/json.h"
#include "core/memory.h"
#include "fail.h"
#include "kept_log.h"

#include <limits.h>
#include <unistd.h>

// -- messages ---------------------------------------------------------------------

static void messages_are_one_line(void **state)
{
    static const struct gp_log deaf = {NULL, NULL, GP_LEVEL_INFO};
    const struct gp_log errors = {kept_sink, NULL, GP_LEVEL_ERROR};
    char text[5000];
    kept_clear();
    assert_int_equal(gp_fail(NULL, GP_ERR_IO, "unheard"), GP_ERR_IO);
    assert_int_equal(gp_fail(&deaf, GP_ERR_GL, "unheard"), GP_ERR_GL);
    gp_say(NULL, GP_LEVEL_ERROR, "unheard");
    gp_say(&errors, GP_LEVEL_WARN, "unheard");
    gp_say(&errors, GP_LEVEL_INFO, "unheard");
    assert_int_equal(kept_errors, 0);
    assert_string_equal(kept_line, "");
    assert_int_equal(gp_fail(&errors, GP_ERR_DATA, "a\nb\r\nc: %d\n", 7),
                     GP_ERR_DATA);
    assert_string_equal(kept_line, "a b  c: 7 ");
    memset(text, 'x', sizeof text);
    text[sizeof text - 1] = '\0';
    assert_int_equal(gp_fail(&errors, GP_ERR_USAGE, "%s", text), GP_ERR_USAGE);
    assert_int_equal(strlen(kept_line), sizeof kept_line - 1);
    assert_int_equal(gp_no_memory(&errors, "a.exr"), GP_ERR_BUG);
    assert_string_equal(kept_line,
                        "a.exr: out of memory; close other programs");
    assert_int_equal(gp_no_memory_bare(&errors, "names"), GP_ERR_BUG);
    assert_string_equal(kept_line,
                        "names: out of memory; close other programs");
    assert_int_equal(kept_errors, 4);
}

static void names_move_no_cursor(void **state)
{
    static const char *const row[][2] = {
        {"", ""}, {"a\tb\r\n", "a b  "}, {"\33[31m\7\177", "?[31m??"},
        {"\xc2\x9b" "31m", "??31m"}, {"a\x9b" "31m\x80", "a?31m?"}, // C1
        // text in another order, ends of lines
        {"a\xe2\x80\xaeg\xe2\x80\xaa.", "a???g???."},
        {"\xe2\x81\xa6\xe2\x81\xa9\xe2\x80\x8e", "?????????"},
        {"\xe2\x80\x8f\xd8\x9c\xe2\x80\xa8", "????????"},
        // their neighbours
        {"\xe2\x80\x8d\xe2\x80\x90\xe2\x80\xa7",
         "\xe2\x80\x8d\xe2\x80\x90\xe2\x80\xa7"},
        {"\xe2\x80\xaf\xe2\x81\xa5\xe2\x81\xaa",
         "\xe2\x80\xaf\xe2\x81\xa5\xe2\x81\xaa"},
        {"\xd8\x9b\xd8\x9d", "\xd8\x9b\xd8\x9d"},
        // letters, also whose last byte is that of a C1, and Latin-1
        {"\xc3\x9b\xe2\x82\xac", "\xc3\x9b\xe2\x82\xac"},
        {"\xc2\xa0\xf0\x9f\x8c\x9e", "\xc2\xa0\xf0\x9f\x8c\x9e"},
        {"caf\xe9.exr", "caf\xe9.exr"},
        {"\xe2\x82", "\xe2?"}, {"\xc2", "\xc2"}, // cut off
    };
    for (size_t i = 0; i < COUNT(row); i++) {
        char text[32];
        strcpy(text, row[i][0]);
        gp_make_printable(text);
        assert_string_equal(text, row[i][1]);
        assert_string_equal(gp_printable(row[i][0]).text, row[i][1]);
    }
    const struct gp_log log = {kept_sink, NULL, GP_LEVEL_ERROR};
    gp_fail(&log, GP_ERR_IO, "%s: \x9b", "\xc2\x9b");
    assert_string_equal(kept_line, "??: ?");
}

static void json_is_whole_or_null(void **state)
{
    static const struct { const char *bytes, *text; } rows[] = {
        {"", "\"\""}, {"a", "\"a\""},
        {"\xc3\xa4\xff", "\"\xc3\xa4\xef\xbf\xbd\""},
        {"\xe0\x80\x80", // overlong: three bytes that are none
         "\"\xef\xbf\xbd\xef\xbf\xbd\xef\xbf\xbd\""},
        {"\xf0\x9f\x8c\x9e", "\"\xf0\x9f\x8c\x9e\""},
        {"\x1b\x7f\xc2\x9b\xc2\xa0", // controls, the same for a reader
         "\"\\u001B\\u007F\\u009B\xc2\xa0\""},
        {"\xe2\x80\xae\xe2\x81\xa9\xd8\x9c", "\"\\u202E\\u2069\\u061C\""},
        {"\xed\xa0\x80", // half of a surrogate pair
         "\"\xef\xbf\xbd\xef\xbf\xbd\xef\xbf\xbd\""},
    };
    for (size_t i = 0; i < COUNT(rows); i++) {
        char *const text = gp_json_print(gp_json_name(rows[i].bytes),
                                         JSON_ENCODE_ANY);
        assert_string_equal(text, rows[i].text);
        free(text);
    }
    assert_null(gp_json_print(NULL, 0));
    // a list of three names: whatever cannot be allocated, there is no text
    const long before = fail_blocks();
    bool failed = true;
    for (int n = 1; failed; n++) {
        fail_at(FAIL_ALLOC, n);
        json_t *const list = json_array();
        for (int i = 0; i < 3; i++)
            json_array_append_new(list, gp_json_name("a"));
        char *const text = gp_json_print(list, JSON_COMPACT);
        failed = fail_end();
        assert_true(failed || n > 10);
        if (failed)
            assert_null(text);
        else
            assert_string_equal(text, "[\"a\",\"a\",\"a\"]");
        free(text);
        assert_int_equal(fail_blocks(), before);
    }
}

static void bridges_are_looked_for(void **state)
{
    char folder[] = "/tmp/glarepp-bridge-XXXXXX", path[64], why[512];
    char longest[PATH_MAX + 8];
    assert_non_null(mkdtemp(folder));
    snprintf(path, sizeof path, "%s/odd.so", folder);
    FILE *const f = fopen(path, "w");
    assert_non_null(f);
    fputs("no library\n", f);
    fclose(f);
    memset(longest, 'a', sizeof longest - 1);
    longest[sizeof longest - 1] = '\0';
    const struct { const char *folder, *name, *text; } rows[] = {
        {folder, "odd.so", "odd.so"},         // there, but no library
        {folder, "none.so", "none.so not found"},
        {"", "odd.so", "odd.so not found"},
        {NULL, "odd.so", "odd.so not found"},
        {longest, "odd.so", "odd.so not found"},
    };
    for (size_t i = 0; i < COUNT(rows); i++) {
        if (rows[i].folder)
            set_env("GLAREPP_BRIDGES", rows[i].folder);
        else
            set_env("GLAREPP_BRIDGES", NULL);
        for (int lost = 0; lost < 2; lost++) {
            fail_always.links = lost; // the program does not know where it is
            assert_null(
                gp_bridge_open(rows[i].name, "none", 1, why, sizeof why));
            if (!strstr(why, rows[i].text))
                fail_msg("row %zu: \"%s\"", i, why);
        }
    }
    fail_always.links = false;
    unlink(path);
    rmdir(folder);
    set_env("GLAREPP_BRIDGES", NULL);
}

/* Only the samples asked for become 0, in few as in many, and no plane has samples
 * of another. */
static void planes_are_cleared(void **state)
{
    static const size_t sizes[] = {1, 100, 300000};
    for (size_t k = 0; k < COUNT(sizes); k++) {
        const size_t n = sizes[k], from = n / 4, count = n - n / 2;
        struct gp_planes p;
        assert_ok(gp_planes_make(NULL, "test", n, &p));
        for (size_t i = 0; i < 3 * n; i++)
            p.c[i / n][i % n] = (float) (1 + i / n);
        gp_planes_clear(&p, from, 0);
        gp_planes_clear(&p, from, count);
        for (size_t i = 0; i < 3 * n; i++) {
            const bool inside = i % n >= from && i % n < from + count;
            assert_true(p.c[i / n][i % n] ==
                        (inside ? 0.0f : (float) (1 + i / n)));
        }
        gp_planes_free(&p);
    }
}

/* MurmurHash3_x86_32: the check of SMHasher's VerificationTest(), and the two hashes
 * that the specification of Cryptomatte prints. */
static void hashes_are_published(void **state)
{
    uint8_t key[256], hashes[4 * 256];
    for (unsigned i = 0; i < 256; i++) {
        key[i] = (uint8_t) i;
        const uint32_t hash = gp_murmur3(key, i, 256 - i);
        memcpy(hashes + 4 * (size_t) i, &hash, sizeof hash);
    }
    assert_int_equal(gp_murmur3(hashes, sizeof hashes, 0), 0xb0f57ee3u);
    assert_int_equal(gp_murmur3("torus", 5, 0), 4053562365u);
    assert_int_equal(gp_murmur3("равнина", 14, 0), 2518896926u);
}

SUITE_OF(small, NULL, NULL, names_move_no_cursor, json_is_whole_or_null,
         messages_are_one_line, bridges_are_looked_for, planes_are_cleared,
         hashes_are_published)
