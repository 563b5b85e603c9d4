#pragma once

#include "app/page/clip_budget.h"
#include "app/simulate/session_body.h"

namespace pliant {

/// Appends what the page's solver needs: the sections `levels`, with bodies of fewer driving particles for slower
/// devices, and `solver`, the module, and what the header says of them.  Where the object cannot be played with, the
/// header says why.
void add_solver(ClipFile& file, const CodedClip& clip, const SessionSetup& setup, const Scene& scene,
                const MovingScene& moving);

/// Bytes that add_solver takes at most in the file.
size_t solver_bytes(const SessionSetup& setup, const MovingScene& moving);

}  // namespace pliant
