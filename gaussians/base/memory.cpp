#include "gaussians/base/memory.h"

#include <cstddef>  // defines __GLIBC__

#if defined(__GLIBC__)
#include <malloc.h>
#endif

namespace pliant {

void keep_freed_memory() {
#if defined(__GLIBC__)
  mallopt(M_MMAP_MAX, 0);
  mallopt(M_TRIM_THRESHOLD, 1 << 30);
  mallopt(M_TOP_PAD, 16 << 20);
#endif
}

}  // namespace pliant
