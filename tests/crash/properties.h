#pragma once

#include <cstdint>

#include "survival.h"

namespace annulus::test {

/// Rows D1, D2, D3, D5: a scan of `levels` with every call of the disk failing in turn, in each of the five ways.
/// Whatever happens: an error that is final, everything acknowledged before it is there, no sync is believed after one
/// that failed, nothing is tried for ever, and a power cut afterwards costs no durable level.
Tally FailEveryCall(const Subject& subject, std::uint32_t levels);

/// Row D6: the recording of `levels` cut at every `step`-th byte gives back exactly the levels that are whole.
Tally CutTheFile(const Subject& subject, std::uint32_t levels, std::size_t step);

/// Row D7: every `step`-th bit of a recording of `levels` flipped costs at most what was written with it (one level),
/// changes none, and is reported.
Tally FlipBits(const Subject& subject, std::uint32_t levels, std::size_t step);

/// P4: whole writes missing from the middle, done twice, or exchanged with their neighbours.
Tally RearrangeWrites(const Subject& subject, std::uint32_t levels);

/// H7: after a power cut a new recording of the same name begins; the one that was interrupted stays readable.
Tally StartAgain(const Subject& subject, std::uint64_t states);

/// What is left of power cuts and of flipped bits, recovered: whole, the same levels, the original untouched, loss
/// told, the same bytes when it is done again.
Tally Recover(const Subject& subject, std::uint64_t states);

}  // namespace annulus::test
