# Chooses the instruction set: x86-64-v3 (AVX2, BMI2, popcount) where the building machine has it, else the compiler's default.
# The encoded bytes never depend on it; only the speed does. Rows name the flags they were measured with.
set(CVRBENCH_ARCH_FLAGS "")
if(CVRBENCH_ARCH STREQUAL "auto")
  if(CMAKE_SYSTEM_PROCESSOR MATCHES "x86_64|AMD64" AND EXISTS /proc/cpuinfo)
    file(STRINGS /proc/cpuinfo cpu_flags REGEX "^flags" LIMIT_COUNT 1)
    if(cpu_flags MATCHES " avx2 " AND cpu_flags MATCHES " bmi2 " AND cpu_flags MATCHES " fma ")
      set(CVRBENCH_ARCH_FLAGS -march=x86-64-v3)
    endif()
  endif()
elseif(NOT CVRBENCH_ARCH STREQUAL "none")
  set(CVRBENCH_ARCH_FLAGS -march=${CVRBENCH_ARCH})
endif()
