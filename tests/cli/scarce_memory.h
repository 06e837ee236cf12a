#pragma once

/// While true, operator new throws std::bad_alloc in this thread.
extern thread_local bool no_memory_is_left;
