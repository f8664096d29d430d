# The host tool: matrig, and matrig-study, which it starts for studies (host/commands/studies.h).
host_src := $(filter-out host/main.c host/study/% %/cvode.c %/error_study.c,$(wildcard host/*.c host/*/*.c host/*/*/*.c))
# What needs GSL or SUNDIALS, and the commands that run there.
study_src := $(filter-out host/study/main.c,$(wildcard host/study/*.c host/study/*/*.c)) $(filter %/cvode.c %/error_study.c,$(wildcard host/sim/*.c host/sim/*/*.c))
host_lib := $(B)/host/libhost.a
study_lib := $(B)/host/libstudy.a
study_objects := $(call objects,host,$(study_src))
# What matrig-study has beyond matrig. cvode as an object: the solver is there when it is linked (host/sim/solvers/stepper.h).
study_parts := $(filter %/cvode.o,$(study_objects)) $(study_lib)
# libserialport is LGPL-3.0-or-later, GSL GPL-3.0-or-later: matrig links the former, matrig-study both, matrig-board (GPL-2.0) neither:
# GPL-2.0 and 3.0 do not go together.
HOST_LIBS := -lsqlite3 -ljansson -lmicrohttpd -lserialport -lmd -lm
STUDY_LIBS := -lsundials_cvode -lsundials_nvecserial -lsundials_sunmatrixband -lsundials_sunlinsolband -lgsl -lgslcblas $(HOST_LIBS)

programs := $(B)/matrig $(B)/matrig-board
studies := $(B)/matrig-study
# matrig-board(1) is the program's; `matrig board --help` has the command.
commands := $(filter-out board,$(shell sed -n 's/^COMMAND([A-Z]*, \([a-z]*\)).*/\1/p' host/commands/commands.def))
manuals := $(B)/matrig.1 $(B)/matrig-board.1 $(commands:%=$(B)/matrig-%.1)

# The solvers' loops run over several mats at a time: O3 lets the compiler use vector instructions, without changing a
# result; the exceptions' flags are not looked at.
$(B)/host/host/sim/%.o: HOST_FLAGS += -O3 -fno-trapping-math
# Vectors go from function to function, but all of those are inline: no calling convention is in it.
$(B)/host/host/sim/models/%.o $(B)/host/host/sim/solvers/chain.o: HOST_FLAGS += -Wno-psabi
# GSL's element access inline, without range checks: the bootstrap of a fit is made of it.
$(B)/host/host/study/fit/%.o: HOST_FLAGS += -DHAVE_INLINE -DGSL_RANGE_CHECK_OFF
$(study_objects): | $(B)/.study-packages
$(B)/host/%.o: %.c | $(B)/.demo-packages
	@mkdir -p $(@D)
	$(call say,CC,$<)$(CC) $(HOST_FLAGS) $(COVERAGE) -c $< -o $@

$(host_lib): $(call objects,host,$(host_src))
$(study_lib): $(filter-out %/cvode.o,$(study_objects))
$(B)/host/lib%.a:
	@rm -f $@
	$(call say,AR,$@)$(AR) rcs $@ $^

$(B)/matrig: $(B)/host/host/main.o $(host_lib) $(common_lib)
	$(call link,$(HOST_LIBS))
$(B)/matrig-study: $(B)/host/host/study/main.o $(study_parts) $(host_lib) $(common_lib)
	$(call link,$(STUDY_LIBS))

# Man pages, a page per command, from what --help prints, dated by the commit. RUN: what runs programs of another machine.
man = $(call say,GEN,$@)SOURCE_DATE_EPOCH=$(epoch) help2man --no-info --name='$(1)' --output=$@
$(B)/matrig.1: $(B)/matrig host/matrig.h2m | $(B)/.study-packages
	$(call man,measuring system for a model landing-mat runway) --include=host/matrig.h2m '$(RUN) $<'
$(commands:%=$(B)/matrig-%.1): $(B)/matrig-%.1: $(B)/matrig | $(B)/.study-packages
	$(call man,command $* of matrig) --version-string="$$($(RUN) $< --version | sed s/matrig/matrig-$*/)" --help-option='$* --help' '$(RUN) $<'
