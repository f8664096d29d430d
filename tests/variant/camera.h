/* A rig with a camera: its pulse and its frames are told. */
#include "firmware/builtin.h"

#undef BUILTIN_CAMERA
#define BUILTIN_CAMERA 1
