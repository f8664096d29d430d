# The board's statements against the host's.
$(B)/tests/identity/draw: $(patsubst %.c,$(B)/%.o,$(wildcard tests/identity/*.c) tests/board/truth_run.c tests/score/truth.c tests/runs/runfile.c) $(host_lib) $(common_lib)
	$(call link,$(HOST_LIBS))
test-programs: $(B)/tests/identity/draw

.PHONY: identity
identity: all $(B)/tests/identity/draw ## longer | LANDINGS=20 SEED=1: the board's statements against the host's, bit for bit, on seeded landings
	@LANDINGS=$(or $(LANDINGS),20) SEED=$(or $(SEED),1) tests/cli/identity.sh
