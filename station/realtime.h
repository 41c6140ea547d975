#pragma once

#include "base/result.h"

namespace annulus {

/// Keeps this process's memory from being swapped out, now and later. An Error says why it may not be: then a page that
/// has to be read from the disk can make a control tick late.
Status LockMemory();

/// Whether a thread of this process may have the priority `priority` (SCHED_FIFO); tried on a thread of its own.
Status MayTakePriority(int priority);

}  // namespace annulus
