/* Included by every header of phynness: visibility of symbols in a shared library.
 *
 * Programs that use the shared library on Windows must define PHYNNESS_SHARED; its CMake target defines it. */
#ifndef PHYNNESS_API_H
#define PHYNNESS_API_H

#include <stddef.h>
#include <stdint.h>

/* Initial value of reserved words, which are 0: C++ sets them, in C a struct that the caller fills begins as {0}. */
#ifdef __cplusplus
#define PHN_ZEROS = {}
#else
#define PHN_ZEROS
#endif

#if defined(_WIN32) && defined(PHYNNESS_BUILDS_SHARED)
#define PHN_API __declspec(dllexport)
#elif defined(_WIN32) && defined(PHYNNESS_SHARED)
#define PHN_API __declspec(dllimport)
#elif defined(__GNUC__)
#define PHN_API __attribute__((visibility("default")))
#else
#define PHN_API
#endif

#endif
