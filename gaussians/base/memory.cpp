#include "gaussians/base/memory.h"

#include <cstddef>  // defines __GLIBC__

#if defined(__GLIBC__)
#include <malloc.h>
#endif

namespace pliant {

void keep_freed_memory() {
#if defined(__GLIBC__)
  constexpr int kLargest = 1 << 30;  // a single block above this size is still mapped on its own
  mallopt(M_MMAP_THRESHOLD, kLargest);
  mallopt(M_TRIM_THRESHOLD, kLargest);
  mallopt(M_TOP_PAD, 16 << 20);
#endif
}

}  // namespace pliant
