/* app/options: what is said of lines that are wrong, or do nothing. */
#include "unit.h"
#include "app/option_line.h"

struct error_row {
    const char *line;
    const char *part;  // of the message
};

static const struct error_row errors[] = {
    {"", "no input; write glarepp -o out.png frame.exr"},
    {"-o a.png", "no input"},
    {"f.exr", "nothing to make; write glarepp -o out.png f.exr"},
    {"-v -t 2 f.exr", "nothing to make"},
    {"--gian 2 i", "--gian: unknown option; did you mean --gain?"},
    {"--gian=2 i", "--gian: unknown option; did you mean --gain?"},
    {"--treshold 2 i", "did you mean --threshold?"},
    {"--Knee 2 i", "did you mean --knee?"},
    {"--xyzzyquux i", "glarepp --help lists them"},
    {"--x i", "glarepp --help lists them"},
    {"-Z i", "-Z: unknown option"},
    {"--help-ma i", "did you mean --help?"},
    {"-o a i --gain", "--gain: needs a value; give G"},
    {"-o a i -g", "-g: needs a value"},
    {"-o --hdr i", "-o: needs a value (found the option --hdr)"},
    {"-o a i --dither=1", "takes no value (found \"1\")"},
    {"-o a i -qv", "takes no value (found \"v\")"},
    {"-o '' i", "--output: needs a value"},
    {"-o a i --depth ''", "--depth: needs a value"},
    {"-o a i --depth=", "--depth: needs a value"},
    {"-o a i -g ''", "--gain: not a number (found \"\")"},
    {"-o a i -g x", "--gain: not a number (found \"x\")"},
    {"-o a i -g 1x", "--gain: not a number"},
    {"-o a i -g 1,5", "--gain: not a number"},
    {"-o a i -g -0.1", "--gain: out of range (found -0.1)"},
    {"-o a i -g nan", "--gain: out of range (found nan)"},
    {"-o a i -g inf", "--gain: out of range"},
    {"-o a i -t nan", "--threshold: out of range"},
    {"-o a i -t -nan", "--threshold: out of range"},
    {"-o a i -t 1e39", "--threshold: out of range (found 1e39)"},
    {"-o a i --knee 1.001", "give 0 to 1"},
    {"-o a i --max-value 0", "give more than 0"},
    {"-o a i --max-value nan", "--max-value: out of range"},
    {"-o a i --exposure -33", "give -32 to 32"},
    {"-o a i --threads 1.5", "--threads: not a whole number"},
    {"-o a i --threads -1", "--threads: out of range"},
    {"-o a i --threads 99999999999999999999", "--threads: out of range"},
    {"-o a i --max-pixels 0", "--max-pixels: out of range"},
    {"-o a i --max-pixels 1e6", "--max-pixels: not a whole number"},
    {"-o a i --kernel-center 1", "--kernel-center: not two numbers"},
    {"-o a i --kernel-center 1,", "--kernel-center: not two numbers"},
    {"-o a i --kernel-center 1,2,3", "--kernel-center: not two numbers"},
    {"-o a i --kernel-center ,2", "--kernel-center: not two numbers"},
    {"-o a i --kernel-center nan,2", "--kernel-center: out of range"},
    {"-o a i --kernel-center 1,inf", "--kernel-center: out of range"},
    {"-o a i -e gpu", "(found \"gpu\"); give one of auto, direct, fft, splat"},
    {"-o a i -e ''", "--engine: no such value"},
    {"-o a i --tonemap filmic", "give one of reinhard, reinhard-extended"},
    {"-o a i -k builtin:foo", "give one of builtin:eye"},
    {"-o a i --mix screen", "give one of add, scatter"},
    {"-o a i --compression lzw", "none, rle, zips, zip, piz, pxr24, b44"},
    {"-o a i --depth-bits 12", "give one of 8, 16"},
    {"-o a i --debug foo=x", "give one of sensors"},
    {"-o a i --debug sensors", "write sensors=FILE"},
    {"-o a i --debug sensors=", "write sensors=FILE"},
    {"-o a i --mix scatter -g 1.5", "more light would be scattered"},
    {"-o a i --verify", "--verify: its result would be shown nowhere"},
    {"-o a i --sun 1", "--sun: not the numbers that it takes"},
    {"-o a i --sun 1,2,3,4", "write X,Y[,R]"},
    {"-o a i --sun 1,2,", "--sun: not the numbers that it takes"},
    {"-o a i --sun 1,inf", "--sun: out of range"},
    {"-o a i --sun 1,2,-1", "--sun: a negative radius (found -1)"},
    {"-o a i --sun 1,2 --sun-dir 0,0,1", "leave one out"},
    {"-o a i --sun 1,2 --sun-color 1,2", "--sun-color: two numbers"},
    {"-o a i --sun 1,2 --sun-color -1", "--sun-color: out of range"},
    {"-o a i --sun 1,2 --sun-map 5", "--sun-map: odd (found 5)"},
    {"-o a i --sun 1,2 --sun-map 258", "give 2 to 256"},
    {"-o a i --sun 1,2 --flare f", "--flare: the sun has no flux"},
    {"-o a i --lights l --sun-color 1", "--sun-color: there is no sun"},
    {"-o a i --flare f", "--flare: there is no light"},
    {"-o a i --mask A", "--mask: there is no light"},
    {"-o a i --sun-method mask", "--sun-method: there is no light"},
    {"-o a i --debug sunmap=f", "--debug sunmap: there is no light"},
    {"-o a i --sun-map 16", "--sun-map: there is no light"}, // its default
    {"-o a i --sun-adapt 0", "--sun-adapt: there is no light"},
    {"-o a i --view v", "--view: there is no config"},
    {"--hdr h i --ocio c --view v", "--view: there is no picture to show"},
    {"-o a i --ocio c --output-space s", "there is no frame to convert"},
    {"-o a i --ocio c --tonemap reinhard", "--tonemap: --ocio takes its"},
    {"bench --paper --sun 1,2", "--paper: its frames have no depth"},
    {"bench --sun 1,2 --flare f i", "--flare: not for glarepp bench"},
    {"-o a i --group 0", "--group: out of range (found 0); give 1 to 64"},
    {"-o a i --group 3", "--group: not a power of two (found 3)"},
    {"-o a i --group 128", "--group: out of range"},
    {"-o a i --group x", "--group: not a whole number"},
    {"-o a i --cluster 12", "--cluster: not a power of two (found 12)"},
    {"-o a i --cluster -8", "--cluster: out of range"},
    {"-o a i --cluster 1", "no larger than --group (found 1 and 4)"},
    {"-o a i --cluster 4", "no larger than --group (found 4 and 4)"},
    {"-o a i --group 1 --cluster 1", "no larger than --group"},
    {"-o a i --cluster-fill 0", "give more than 0, up to 1"},
    {"-o a i --cluster-fill 1.01", "--cluster-fill: out of range"},
    {"-o a i --shrink 1", "--shrink: out of range"},
    {"-o a i --shrink nan", "--shrink: out of range"},
    {"-o a i --tolerance -1", "--tolerance: out of range"},
    {"-o a i --tolerance nan", "--tolerance: out of range"},
    {"-o a i --group-method mean", "give one of centroid, moments, core"},
    {"-o a i --primitive disc", "give one of auto, quad, point, tile"},
    {"-o a i --rotate inf", "--rotate: out of range"},
    {"-o a i --rotate north", "--rotate: not a number"},
    {"-o a i --debug polygons=", "write polygons=FILE"},
    {"-o a i --csv x", "--csv: not for pictures; write glarepp bench --csv"},
    {"-o a i --csw", "unknown option; glarepp --help lists them"},
    {"bench", "no input; write glarepp bench frame.exr"},
    {"bench a b", "b: one frame at a time"},
    {"bench --paper a", "--paper: brings its own frames (found a"},
    {"bench -o a b", "--output: not for glarepp bench"},
    {"bench --hdr a b", "--hdr: not for glarepp bench"},
    {"bench --papr", "did you mean --paper?"},
    {"bench --outptu a", "unknown option; glarepp bench --help lists them"},
    {"bench a --runs 0", "--runs: out of range (found 0); give 1 to 1000"},
    {"bench a --runs 1001", "--runs: out of range"},
    {"bench a --mix scatter -g 2", "more light would be scattered"},
};

static void errors_say_what_is_wrong(void **state)
{
    (void) state;
    for (size_t i = 0; i < sizeof errors / sizeof errors[0]; i++) {
        const struct error_row *r = &errors[i];
        struct gp_settings s;
        gp_status st = parse(r->line, &s);
        if (st != GP_ERR_USAGE || lines != 1 || !strstr(said, r->part))
            fail_msg("\"%s\": status %d, %d lines: %s", r->line, st, lines,
                     said);
        gp_settings_free(&s);
    }
}

static void warnings(void **state)
{
    (void) state;
    struct gp_settings s;
    assert_int_equal(parse("-o a i --tonemap none --exposure 1", &s), GP_OK);
    assert_non_null(strstr(said, "--exposure: does nothing"));
    gp_settings_free(&s);
    assert_int_equal(parse("-o a i --tonemap hable --white 3", &s), GP_OK);
    assert_non_null(strstr(said, "--white: does nothing"));
    gp_settings_free(&s);
    assert_int_equal(parse("-o a i -e fft --group 8", &s), GP_OK);
    assert_non_null(strstr(said, "--group: does nothing with --engine fft"));
    gp_settings_free(&s);
    assert_int_equal(parse("-o a i -e direct --cluster 8", &s), GP_OK);
    assert_non_null(strstr(said, "--cluster: does nothing"));
    gp_settings_free(&s);
    assert_int_equal(parse("-o a i -e fft --group 4", &s), GP_OK);
    assert_non_null(strstr(said, "--group: does nothing")); // its default
    gp_settings_free(&s);
    assert_int_equal(parse("-o a i -e splat --tolerance 0.1", &s), GP_OK);
    assert_non_null(strstr(said, "--tolerance: does nothing"));
    gp_settings_free(&s);
    assert_int_equal(parse("-o a i -e fft --shrink 0 --debug polygons=p", &s),
                     GP_OK);
    assert_int_equal(lines, 0); // the polygons are drawn by it
    gp_settings_free(&s);
    assert_int_equal(parse("-o a i --sun 1,2 --sun-sum 8bit", &s), GP_OK);
    assert_non_null(strstr(said, "--sun-sum: does nothing"));
    gp_settings_free(&s);
    assert_int_equal(parse("--report r --no-clobber i", &s), GP_OK);
    assert_non_null(strstr(said, "--no-clobber: does nothing"));
    gp_settings_free(&s);
    assert_int_equal(parse("-o a i --sun 1,2 --sun-map 8 --debug sunmap=m",
                           &s), GP_OK);
    assert_int_equal(lines, 0); // the picture has that size
    gp_settings_free(&s);
    assert_int_equal(parse("-q -o a i --tonemap hable --white 3", &s), GP_OK);
    assert_int_equal(lines, 0);
    gp_settings_free(&s);
}

SUITE(options_wrong)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(errors_say_what_is_wrong),
        cmocka_unit_test(warnings),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
