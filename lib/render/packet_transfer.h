#pragma once
#include "index/macrocells.h"
#include "render/optics.h"
#include "render/packet_job.h"

namespace vol::render {

/// Tabulates a transfer function over the range of the data.
///
/// Opacity and colour are linear between their points, and every line of the table lies between two points,
/// so colour is exact up to float rounding. Extinction -log(1 - a) is not linear: the table is made fine
/// enough that its chords err by at most 2e-6 of the extinction (or 1e-9 for one reference length); where
/// 16384 buckets are not enough, the lines hold the opacity itself and the kernel takes the logarithm. An
/// error of e of the extinction changes a ray's colour by at most e max(tau e^-tau) = 0.37 e. Besides, for
/// registers, a colour of few pieces as a line a piece, and an extinction of few as polynomials
/// (extinction_pieces.h).
///
/// \param integral   the data are integers: buckets are aligned to them where the range allows
/// \param steps      length of a step over the reference length
/// Preintegrated and split: segments are cut at the transfer function's points, and on ramps of opacity also
/// wherever 1 - opacity has changed by a factor of 1.5, so that three Gauss nodes integrate the extinction of
/// a piece to 1e-6 of itself.
///
/// \returns false when two transfer-function points share a bucket even in the finest table, and for
/// preintegrated
///          where opacity 1 occurs
[[nodiscard]] bool tabulate(const Optics& optics, const index::Macrocells::Range& range, bool integral,
                            double steps, PacketRule rule, PacketTransfer& table);

}  // namespace vol::render
