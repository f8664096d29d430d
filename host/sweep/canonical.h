/* Canonical hashes of JSON values: what makes a case's id.
 *
 * Two values have the same hash when they say the same: order of keys, white space, 12000 or
 * 12000.0, and keys that begin with _ (comments) do not count. FNV-1a, 64 bits (Fowler, Noll, Vo),
 * over a text with sorted keys and numbers of 17 significant digits. */
#ifndef MATRIG_HOST_SWEEP_CANONICAL_H
#define MATRIG_HOST_SWEEP_CANONICAL_H

#include <jansson.h>
#include <stddef.h>
#include <stdint.h>

#define FNV_BASIS 0xcbf29ce484222325u

/* FNV-1a of `size` bytes, going on from `hash`; FNV_BASIS to begin. */
uint64_t fnv1a(uint64_t hash, const void *bytes, size_t size);

/* Goes on from `hash` with the value; NULL counts as null. */
uint64_t canonical_hash(uint64_t hash, const json_t *value);

#endif
