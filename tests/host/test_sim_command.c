/* matrig sim: exit codes, one line per error, and the JSON object. */

#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include "host/commands/commands.h"
#include "tests/cmocka_all.h"

#define FOLDER "build/test-tmp/"
#define SCENE  FOLDER "test_sim_command.json"

static char out[1 << 20];
static char err[4096];

static void read_text(const char *path, char *text, size_t room)
{
    FILE *file = fopen(path, "rb");
    assert_non_null(file);
    text[fread(text, 1, room - 1, file)] = '\0';
    fclose(file);
}

static void write_text(const char *path, const char *text)
{
    FILE *file = fopen(path, "wb");
    assert_non_null(file);
    fputs(text, file);
    assert_int_equal(fclose(file), 0);
}

enum form { TEXT, JSON };

/* Run `sim` with these words (NULL at the end) in a process of its own, which it may end; what it
 * printed is in out and err afterwards. */
static int sim(enum form form, const char *const *words)
{
    const struct cli cli = {.json = form == JSON};
    char *argv[12] = {"sim"};
    int argc = 1, status = 0;
    for (; words[argc - 1]; argc++)
        argv[argc] = (char *)(uintptr_t)words[argc - 1];
    fflush(NULL);
    pid_t child = fork();
    if (child == 0) {
        if (!freopen(FOLDER "sim.out", "wb", stdout) || !freopen(FOLDER "sim.err", "wb", stderr))
            _exit(99);
        exit(command_sim.run(argc, argv, &cli));
    }
    assert_int_equal(waitpid(child, &status, 0), child);
    assert_true(WIFEXITED(status));
    read_text(FOLDER "sim.out", out, sizeof out);
    read_text(FOLDER "sim.err", err, sizeof err);
    return WEXITSTATUS(status);
}

#define SIM(form, ...) sim(form, (const char *const[]){__VA_ARGS__, NULL})

static void one_error_line(const char *names)
{
    assert_string_equal(out, "");
    if (!strstr(err, names))
        fail_msg("'%s' does not name '%s'", err, names);
    assert_ptr_equal(strchr(err, '\n'), err + strlen(err) - 1);
}

TEST(the_object_is_the_contract)
{
    static const char *const keys[] = {"scene",          "model",   "solver",      "status",
                                       "t_end_s",        "run_ms",  "rhs",         "steps",
                                       "rejected",       "events",  "max_lift_ft", "bow_wave",
                                       "error_estimate", "outputs", "active"};
    size_t count = 0;
    const char *key;
    json_t *value;
    assert_int_equal(SIM(JSON, "host/scenes/friction_block.json"), 0);
    assert_string_equal(err, "");
    json_t *object = json_loads(out, 0, NULL);
    assert_non_null(object);
    json_object_foreach(object, key, value)
    {
        assert_true(count < sizeof keys / sizeof keys[0]);
        assert_string_equal(key, keys[count++]);
    }
    assert_int_equal(count, sizeof keys / sizeof keys[0]);
    assert_string_equal(json_string_value(json_object_get(object, "status")), "ok");
    assert_string_equal(json_string_value(json_object_get(object, "model")), "chain");
    json_t *outputs = json_object_get(object, "outputs");
    assert_int_equal(json_array_size(outputs), 3);
    const double at_rest = 0.5 * 32.174 * 0.01; /* f g t^2, as the scene says */
    json_t *last = json_array_get(outputs, 2);
    assert_true(fabs(json_number_value(json_object_get(last, "t_s")) - 0.3) < 1e-12);
    assert_true(fabs(json_number_value(json_object_get(json_object_get(last, "u_ft"), "1")) -
                     at_rest) < 1e-6);
    assert_true(json_number_value(json_object_get(last, "lift_ft")) == 0.0);
    assert_int_equal(json_integer_value(json_object_get(last, "lift_node")), 1);
    json_t *estimate = json_object_get(object, "error_estimate");
    assert_true(json_number_value(json_object_get(estimate, "u_ft")) > 0.0);
    assert_true(json_is_number(json_object_get(estimate, "lift_ft")));
    assert_true(json_is_false(json_object_get(object, "bow_wave")));
    json_t *active = json_object_get(object, "active");
    assert_int_equal(json_integer_value(json_object_get(active, "mats_max")), 1);
    assert_true(json_array_size(json_object_get(active, "left_out")) >= 2);
    json_decref(object);
}

TEST(an_unstable_run_says_where)
{
    assert_int_equal(SIM(JSON, "host/scenes/wave.json", "--dt", "1e-3"), 5);
    assert_non_null(strstr(err, "unstable"));
    assert_non_null(strstr(err, "mat 1 at 0 s"));
    json_t *object = json_loads(out, 0, NULL);
    assert_non_null(object);
    assert_string_equal(json_string_value(json_object_get(object, "status")), "unstable");
    assert_int_equal(json_integer_value(json_object_get(object, "mat")), 1);
    assert_int_equal(json_array_size(json_object_get(object, "outputs")), 0);
    /* no answer is not "no bow wave" */
    assert_true(json_is_null(json_object_get(object, "bow_wave")));
    assert_true(json_is_null(json_object_get(object, "max_lift_ft")));
    json_decref(object);
    assert_int_equal(SIM(TEXT, "host/scenes/wave.json", "--dt=1e-3"), 5);
    one_error_line("stability limit");
}

TEST(a_limit_leaves_what_was_computed)
{
    assert_int_equal(SIM(JSON, "host/scenes/consistent_fig3_11_12000.json", "--limit", "0.001"), 5);
    assert_non_null(strstr(err, "by the computing limit of 0.001 s"));
    json_t *object = json_loads(out, 0, NULL);
    assert_non_null(object);
    assert_string_equal(json_string_value(json_object_get(object, "status")), "interrupted");
    assert_true(json_number_value(json_object_get(object, "t_s")) <
                json_number_value(json_object_get(object, "t_end_s")));
    json_decref(object);
    assert_int_equal(SIM(TEXT, "host/scenes/wave.json", "--limit", "never"), 2);
    one_error_line("--limit");
}

TEST(errors_have_their_exit_codes)
{
    assert_int_equal(SIM(TEXT, "build/test-tmp/none.json"), 3);
    one_error_line("none.json");
    write_text(SCENE, "{\"model\": \"chain\", \"sped\": 3}");
    assert_int_equal(SIM(TEXT, SCENE), 4);
    one_error_line("\"sped\"");
    write_text(SCENE, "{\"model\": \"chain\",\n\n oops}");
    assert_int_equal(SIM(JSON, SCENE), 4);
    one_error_line("line 3 column");
    write_text(SCENE, "{\"model\": \"report\", \"grit\": 3}");
    assert_int_equal(SIM(TEXT, SCENE), 2);
    one_error_line("grit in model report");
    assert_int_equal(SIM(TEXT, "host/scenes/wave.json", "--solver", "bdf"), 2);
    one_error_line("bdf for model chain; give event or staggered");
    assert_int_equal(SIM(TEXT, "host/scenes/wave.json", "--dt", "fast"), 2);
    one_error_line("--dt");
    assert_int_equal(SIM(TEXT, "host/scenes/wave.json", "--frob"), 2);
    one_error_line("--frob");
    assert_int_equal(SIM(TEXT, "--rtol", "1e-6"), 2);
    one_error_line("SCENE");
    assert_int_equal(SIM(TEXT, "host/scenes/wave.json", "--csv", "build/no folder/x.csv"), 3);
    one_error_line("x.csv");
}

TEST(the_table_is_the_history)
{
    double t_s, u_ft, last_t_s = -1.0;
    int rows = 0;
    assert_int_equal(SIM(TEXT, "host/scenes/friction_block.json", "--csv", FOLDER "sim.csv"), 0);
    assert_non_null(strstr(out, "friction block\nmodel             chain\nsolver            "
                                "event\nstatus            ok\n"));
    assert_non_null(strstr(out, "\nerror of movement "));
    read_text(FOLDER "sim.csv", out, sizeof out);
    char *line = strtok(out, "\n");
    assert_string_equal(line, "t_s,u_1_ft");
    while ((line = strtok(NULL, "\n"))) {
        assert_int_equal(sscanf(line, "%lf,%lf", &t_s, &u_ft), 2);
        assert_true(t_s > last_t_s);
        if (t_s < 0.1)
            assert_true(fabs(u_ft - 0.25 * 32.174 * t_s * t_s) < 1e-6);
        last_t_s = t_s;
        rows++;
    }
    assert_int_equal(rows, 1001);
    assert_true(fabs(last_t_s - 0.3) < 1e-9);
}

/* A list for people and for programs; neither with a scene. */
TEST(keys_are_listed)
{
    assert_int_equal(SIM(TEXT, "--keys"), 0);
    assert_non_null(strstr(out, "\nground_damping  0           lb s/ft "));
    assert_non_null(strstr(out, "\nmodel           report "));
    assert_int_equal(SIM(JSON, "--keys"), 0);
    assert_non_null(strstr(out, "\"meaning\":"));
    assert_non_null(strstr(out, "\"ground_damping\":"));
    write_text(SCENE, "{}");
    assert_int_equal(SIM(TEXT, SCENE, "--keys"), 2);
    assert_non_null(strstr(err, "--keys"));
}

static int begin(void **state)
{
    (void)state;
    mkdir("build", 0777);
    mkdir("build/test-tmp", 0777);
    return 0;
}

TESTS_BETWEEN(begin, NULL);
