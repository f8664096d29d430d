/* Scene files. */
#include "host/sim/scene/scene.h"
#include "tests/fuzz/fuzz.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    struct sim_scene scene;
    struct error error = {0};
    if (sim_scene_load(&scene, fuzz_file("scene.json", data, size), &error) == MR_OK) {
        FUZZ_REQUIRE(sim_scene_check(&scene, "scene.json", &error) == MR_OK);
        sim_scene_free(&scene);
    } else {
        FUZZ_REQUIRE(error.text[0]);
    }
    return 0;
}
