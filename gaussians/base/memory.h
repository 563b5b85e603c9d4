#pragma once

namespace pliant {

/// Tells the allocator to keep freed memory for the next picture or time step instead of handing it back to the system:
/// page faults otherwise take a quarter of a frame.  Called once by programs, not by the library.  Does nothing where
/// the C library is not glibc.
void keep_freed_memory();

}  // namespace pliant
