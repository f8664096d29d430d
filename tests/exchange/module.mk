# Readers of other hands. A parser of DBC files that is not ours:
candied := $(NPM)/npm-exchange/node_modules/candied/package.json
$(candied): tests/exchange/package.json tests/exchange/package-lock.json | $(B)/.test-packages
	@mkdir -p $(NPM)/npm-exchange
	@cp $^ $(NPM)/npm-exchange/
	@cd $(NPM)/npm-exchange && npm ci --ignore-scripts --no-audit --no-fund --omit-lockfile-registry-resolved --cache ./cache >npm.log 2>&1 || \
		{ grep -i err npm.log | head -n 3 >&2; echo "cannot fetch candied by npm; see $(NPM)/npm-exchange/npm.log; it needs a network once" >&2; exit 2; }
	@touch $@
test-programs: $(candied)

$(B)/tests/exchange/decode: $(B)/tests/exchange/decode.o $(host_lib) $(common_lib)
	$(call link,$(HOST_LIBS))
