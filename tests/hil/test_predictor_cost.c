/* What the predictor costs on the emulated board, in instructions, by the mat updates and visits it
 * counts itself: the figures that `make error-report` states costs with
 * (tests/error_report/predictor_cost.h). */
#include "hil/debug/profile.h"
#include "tests/error_report/predictor_cost.h"
#include "tests/hil/bench.h"

#define IMAGE  "build/tests/hil/images/predictor_cost.elf"
#define BLOCKS 3000u

struct cost {
    double chain, scan, rest, slow; /* instructions; divisions and roots */
    double updates, visits, blocks, most;
};

static bool one_of(const char *name, const char *const *list)
{
    for (; *list; list++) {
        if (strncmp(name, *list, strlen(*list)) == 0)
            return true;
    }
    return false;
}

/* Lines `COUNT ... NAME` of the profile, by function. */
static void add_up(struct cost *cost, FILE *profile)
{
    static const char *const chain[] = {
        "mr_chain_step",      "step_bay", "update_joint",           "slip",
        "mr_chain_end_block", "moves",    "mr_chain_reset_updates", NULL};
    static const char *const scan[] = {
        "mr_zonescan", "closes",       "is_open",        "find_start",       "find_end",
        "lie",         "end_position", "begin_position", "mr_chain_opening", "mr_chain_compression",
        NULL};
    static const char *const outside[] = {"main",  "measure", "play",   "set_up",
                                          "reset", "memset",  "memcpy", NULL};
    char line[256], name[128];
    bool functions = false;
    while (fgets(line, sizeof line, profile)) {
        double count;
        if (strstr(line, "floating point divide, root"))
            sscanf(line, "%lf", &cost->slow);
        if (strncmp(line, "by ", 3) == 0)
            functions = strncmp(line, "by function", 11) == 0;
        if (!functions || sscanf(line, "%lf %*s %*s %127[^, \n]", &count, name) != 2)
            continue;
        if (one_of(name, chain))
            cost->chain += count;
        else if (one_of(name, scan))
            cost->scan += count;
        else if (!one_of(name, outside))
            cost->rest += count;
    }
}

static struct cost measure(unsigned level, unsigned lacks)
{
    struct cost cost = {0};
    struct mr_symbols symbols;
    char error[256];
    struct hil_board *board = bench_board("predictor_cost", NULL);
    assert_int_equal(hil_symbols_read(&symbols, IMAGE, error, sizeof error), MR_OK);
    bench_control(board, 0, level);
    bench_control(board, 1, BLOCKS);
    bench_control(board, 2, lacks);
    uint64_t t_ps = 0;
    for (unsigned k = 0; k < 1000 && !bench_result(board, 5); k++)
        bench_run(board, t_ps += 100000000); /* 100 us */
    assert_int_equal(bench_result(board, 5), 1);
    hil_profile_begin(board);
    for (unsigned k = 0; k < 400 && !bench_result(board, 55); k++)
        bench_run(board, t_ps += 100000000000); /* 100 ms */
    assert_int_equal(bench_result(board, 55), 1);
    FILE *file = tmpfile();
    assert_int_equal(hil_profile_end(board, &symbols, file), MR_OK);
    rewind(file);
    add_up(&cost, file);
    if (getenv("MATRIG_KEEP_PROFILE")) {
        rewind(file);
        for (int c; (c = getc(file)) != EOF;)
            putchar(c);
    }
    fclose(file);
    cost.blocks = bench_result(board, 0);
    cost.updates = bench_result(board, 1);
    cost.visits = bench_result(board, 2);
    cost.most = bench_result(board, 3);
    assert_int_equal(cost.blocks, BLOCKS);
    hil_symbols_free(&symbols);
    hil_board_destroy(board);
    return cost;
}

TEST(figures_hold)
{
    for (unsigned level = 0; level < 4; level++) {
        struct cost cost = measure(level, 0);
        double cycles = PREDICTOR_CYCLES(cost.updates, cost.visits, cost.blocks);
        double measured = 1.5 * (cost.chain + cost.scan + cost.rest) + 12.5 * cost.slow;
        print_message(
            "level %u: %.0f updates, %.0f visits: %.1f instructions an update, %.1f a visit, %.0f "
            "a block; most in a block %.0f; "
            "divides and roots %.1f a block; cycles/s %.2f %% of 168 MHz, stated %.2f %%\n",
            level, cost.updates, cost.visits, cost.updates > 0 ? cost.chain / cost.updates : 0.0,
            cost.scan / cost.visits, cost.rest / cost.blocks, cost.most, cost.slow / cost.blocks,
            measured / cost.blocks / 1680.0, cycles / cost.blocks / 1680.0);
        assert_true(cycles > 0.8 * measured && cycles < 1.25 * measured);
    }
}

/* No transducer, or one: less work in every block, by nearly an eighth each. A survey costs nothing
 * in the landing either way. (How many mats move is a matter of the landing: readings that stand
 * still hold them.) */
TEST(what_is_not_there_costs_nothing)
{
    enum { NONE = 1, SURVEYED = 2, ONE = 4 };
    struct cost all = measure(0, 0), none = measure(0, NONE), one = measure(0, ONE),
                surveyed = measure(0, SURVEYED);
    double of_all = all.rest / all.blocks, of_none = none.rest / none.blocks,
           of_one = one.rest / one.blocks;
    print_message("instructions a block beside mats and search: eight transducers %.0f, one %.0f, "
                  "none %.0f; surveyed %.0f\n",
                  of_all, of_one, of_none, surveyed.rest / surveyed.blocks);
    print_message("mat updates: eight transducers %.0f, one %.0f, none %.0f\n", all.updates,
                  one.updates, none.updates);
    double each = (of_all - of_none) / 8.0;
    assert_true(each > 50.0);
    assert_true(of_one < of_none + 2.0 * each);
    assert_true(surveyed.rest / surveyed.blocks < 1.02 * of_all);
}
