#pragma once

namespace pliant {

/// Instruction sets that the hot loops are compiled for.  Results are equal bit for bit within one of them.
enum class InstructionSet { kBaseline, kAvx2 };

/// The widest one of this processor.  The environment variable PLIANT_INSTRUCTION_SET=baseline|avx2 asks for a narrower
/// one, for results that equal those of an older machine.
InstructionSet best_instruction_set();

const char* name_of(InstructionSet set);

}  // namespace pliant
