# What board and host both run.
common_src := $(wildcard common/*.c common/onboard/*.c)
common_lib := $(B)/host/libcommon.a
# The predictor and what it is made of, for the programs that have it alone.
predictor_parts := common/predictor common/zonescan common/matchain common/closure

$(common_lib): $(call objects,host,$(common_src))
