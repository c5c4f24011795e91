// Function multiversioning: hot functions are compiled for several instruction sets and chosen at run time.
#pragma once

#if defined(__x86_64__) && defined(__GNUC__) && defined(__linux__) && !defined(__clang__) && !defined(WAYPROOF_SANITIZE)
#define WAYPROOF_MULTIVERSION __attribute__((target_clones("avx512f", "avx2", "default")))
#else
#define WAYPROOF_MULTIVERSION
#endif
