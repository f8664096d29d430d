# What Debian 12 must have: to build and play the demo, beyond that for studies (matrig-study), and to test.
DEMO_PACKAGES := gcc-arm-none-eabi libunicorn-dev libsqlite3-dev libjansson-dev \
	libserialport-dev libmd-dev libmicrohttpd-dev libjs-dygraphs libc6-dev
STUDY_PACKAGES := $(DEMO_PACKAGES) libsundials-dev libgsl-dev help2man
TEST_PACKAGES := $(STUDY_PACKAGES) stm32flash libcmocka-dev zlib1g-dev qemu-system-arm can-utils sqlite3 \
	gdb-multiarch gtkwave python3 python3-can python3-canmatrix groff-base gnuplot-nox clang-format
COVERAGE_PACKAGES := $(TEST_PACKAGES) gcovr
# And a second compiler, for warnings and fuzzing.
CLANG_PACKAGES := $(TEST_PACKAGES) clang cppcheck
# To drive the pages in a browser.
BROWSER_PACKAGES := $(TEST_PACKAGES) chromium poppler-utils python3
# And to test in a Debian without anything.
BARE_PACKAGES := debootstrap iproute2 util-linux
# To check, draw and simulate the reference electronics.
CIRCUIT_PACKAGES := lepton-eda ngspice python3
# To make Debian packages, and to test them in a Debian of their own.
DEB_PACKAGES := $(STUDY_PACKAGES) debhelper dpkg-dev
DEB_TEST_PACKAGES := $(DEB_PACKAGES) lintian python3 $(BARE_PACKAGES)
# And to test real Linux links, in a guest.
LINUX_PACKAGES := $(TEST_PACKAGES) qemu-system-x86 busybox-static iproute2 slurmctld slurmd slurm-client munge parallel

.PHONY: deps
deps: $(B)/.demo-packages $(B)/.test-packages ## every day | install what is missing (Debian packages)

# Checked offline, installed only when missing.
define install_packages
@mkdir -p $(B)
@missing=""; for p in $(1); do \
	dpkg-query -W -f '$${Status}' $$p 2>/dev/null | grep -q 'ok installed' || missing="$$missing $$p"; done; \
if [ -n "$$missing" ]; then \
	run="apt-get install -y --no-install-recommends$$missing"; \
	if [ "$$(id -u)" = 0 ]; then as=""; \
	elif sudo -n true 2>/dev/null; then as="sudo "; \
	else echo "matrig needs packages that only root can install. Run:  apt-get update && $$run" >&2; exit 2; fi; \
	echo "installing:$$missing"; \
	$$as apt-get update -qq && DEBIAN_FRONTEND=noninteractive $$as $$run >$(B)/packages.log 2>&1 || \
		{ tail -n 5 $(B)/packages.log >&2; echo "installing failed; see $(B)/packages.log, or run:  $$as$$run" >&2; exit 2; }; \
fi
@touch $@
endef

$(B)/.demo-packages:
	$(call install_packages,$(DEMO_PACKAGES))
$(B)/.study-packages: $(B)/.demo-packages
	$(call install_packages,$(STUDY_PACKAGES))
$(B)/.test-packages: $(B)/.study-packages
	$(call install_packages,$(TEST_PACKAGES))
$(B)/.browser-packages: $(B)/.test-packages
	$(call install_packages,$(BROWSER_PACKAGES))
$(B)/.bare-packages:
	$(call install_packages,$(BARE_PACKAGES))
$(B)/.deb-packages: $(B)/.study-packages
	$(call install_packages,$(DEB_PACKAGES))
$(B)/.deb-test-packages: $(B)/.deb-packages
	$(call install_packages,$(DEB_TEST_PACKAGES))
$(B)/.linux-packages: $(B)/.test-packages
	$(call install_packages,$(LINUX_PACKAGES))
$(B)/.coverage-packages: $(B)/.test-packages
	$(call install_packages,$(COVERAGE_PACKAGES))
$(B)/.clang-packages: $(B)/.test-packages
	$(call install_packages,$(CLANG_PACKAGES))
$(B)/.circuit-packages:
	$(call install_packages,$(CIRCUIT_PACKAGES))
# All that CI needs, at once.
$(B)/.ci-packages:
	$(call install_packages,$(sort $(CLANG_PACKAGES) $(BROWSER_PACKAGES) $(LINUX_PACKAGES) $(AARCH64_PACKAGES) $(CIRCUIT_PACKAGES)))
