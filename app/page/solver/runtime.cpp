// What Debian's C++ library for WebAssembly leaves out.  Exceptions of the solver reach the page as errors of
// JavaScript.  It cannot unwind: nothing is caught and no destructor runs, so an instance that has thrown is thrown
// away.

#include <cstdlib>
#include <exception>
#include <typeinfo>

#include "gaussians/base/error.h"

extern "C" {

/// Of the page: throws an error with that text.
[[noreturn, clang::import_module("page"), clang::import_name("fail")]] void page_fail(const char* text);

void* __cxa_allocate_exception(size_t size) noexcept { return std::malloc(size); }
void __cxa_free_exception(void* thrown) noexcept { std::free(thrown); }

[[noreturn]] void __cxa_throw(void* thrown, std::type_info* type, void (*)(void*)) {
  // Everything that this program throws is an Error; the rest comes from the standard library.
  if (*type == typeid(pliant::Error)) page_fail(static_cast<pliant::Error*>(thrown)->what());
  page_fail(type->name());
}

/// Thread-local objects live as long as the module.
int __cxa_thread_atexit(void (*)(void*), void*, void*) noexcept { return 0; }
}
