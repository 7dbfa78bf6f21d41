// astcenc.h as Debian's shared library exports it: C names.
#pragma once

#define ASTCENC_DYNAMIC_LIBRARY
#include <astcenc.h>
