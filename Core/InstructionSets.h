// The instruction sets that kernels are compiled for, and tests with them. Include it before anything of Highway.
#pragma once

// All of Highway's but those that would only lengthen the build: processors with SSSE3 and without SSE4 are of 2006.
#ifndef HWY_DISABLED_TARGETS
#define HWY_DISABLED_TARGETS HWY_SSSE3
#endif
