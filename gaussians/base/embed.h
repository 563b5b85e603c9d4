#pragma once

/// Puts the bytes of the file `path` into the program, from name_begin to name_end and followed by a 0; the assembler
/// copies them.  A source that does so is compiled alone (SKIP_UNITY_BUILD_INCLUSION, SKIP_PRECOMPILE_HEADERS) and
/// depends on the file (OBJECT_DEPENDS).
#define PLIANT_EMBED(name, path)                                                \
  __asm__(".pushsection .rodata\n" #name "_begin: .incbin \"" path "\"\n" #name \
          "_end: .byte 0\n"                                                     \
          ".popsection\n");                                                     \
  extern "C" const char name##_begin[], name##_end[]
