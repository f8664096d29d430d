#include "common/status.h"
#include "common/fault.h"
#include "tests/cmocka_all.h"

/* Exit codes are a contract of the command line: 1 limit, 2 usage, 3 I/O, 4 malformed, 5
 * numerics. */
TEST(exit_codes_keep_the_contract)
{
    assert_int_equal(mr_status_exit_code(MR_OK), 0);
    assert_int_equal(mr_status_exit_code(MR_LIMIT), 1);
    assert_int_equal(mr_status_exit_code(MR_USAGE), 2);
    assert_int_equal(mr_status_exit_code(MR_IO), 3);
    assert_int_equal(mr_status_exit_code(MR_TIMEOUT), 3);
    assert_int_equal(mr_status_exit_code(MR_MALFORMED), 4);
    assert_int_equal(mr_status_exit_code(MR_VERSION), 4);
    assert_int_equal(mr_status_exit_code(MR_NUMERICS), 5);
    assert_int_equal(mr_status_exit_code((enum mr_status) - 99), 3);
}

/* The rest by what kind of failure it is (README, exit codes): usage, input or output, malformed,
 * numerics. */
TEST(failures_of_a_kind_exit_alike)
{
    const enum mr_status usage[] = {MR_NOT_NOW, MR_UNKNOWN},
                         malformed[] = {MR_TRUNCATED, MR_CRC, MR_TOO_LONG};
    const enum mr_status input[] = {MR_CLOSED, MR_FULL, MR_UNMODELLED, MR_HALTED, MR_WAIT};
    for (size_t i = 0; i < sizeof usage / sizeof usage[0]; i++)
        assert_int_equal(mr_status_exit_code(usage[i]), 2);
    for (size_t i = 0; i < sizeof malformed / sizeof malformed[0]; i++)
        assert_int_equal(mr_status_exit_code(malformed[i]), 4);
    for (size_t i = 0; i < sizeof input / sizeof input[0]; i++)
        assert_int_equal(mr_status_exit_code(input[i]), 3);
    assert_int_equal(mr_status_exit_code(MR_TOO_FEW), 5);
}

TEST(every_status_has_its_own_text)
{
    for (int a = 0; a >= MR_WAIT; a--) {
        assert_string_not_equal(mr_status_text((enum mr_status)a), "unknown status");
        for (int b = 0; b > a; b--)
            assert_string_not_equal(mr_status_text((enum mr_status)a),
                                    mr_status_text((enum mr_status)b));
    }
    assert_string_equal(mr_status_text((enum mr_status) - 99), "unknown status");
}

TEST(what_is_no_fault_has_no_text)
{
    assert_string_equal(mr_fault_text(MR_FAULT_COUNT), "unknown fault");
}
