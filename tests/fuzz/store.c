#include "host/store/store.h"
#include "tests/fuzz/fuzz.h"

#define USES 256u

struct store *fuzz_store(void)
{
    static struct store *store;
    static unsigned uses;
    struct error error = {0};
    if (store && ++uses < USES)
        return store;
    store_close(store);
    store = NULL;
    uses = 0;
    FUZZ_REQUIRE(store_open(":memory:", STORE_CREATE, &store, &error) == MR_OK &&
                 store_begin(store, &error) == MR_OK);
    return store;
}
