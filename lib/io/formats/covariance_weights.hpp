// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Measurements in the plane with a covariance behind them, its upper triangle row by row.

#include <mapjoin/io/formats/edge_text.hpp>

namespace mapjoin {

/// `x y φ Pxx Pxy Pxφ Pyy Pyφ Pφφ`. A covariance that does not pass the check is rejected.
MeasuredPose<2> read_covariance_edge(TextScanner& text, InformationCheck& check);
/// `x y Pxx Pxy Pyy`, likewise.
MeasuredPoint<2> read_covariance_point(TextScanner& text, InformationCheck& check);

/// The same as they are read; a fault where the information matrix is singular.
Fault put_covariance_edge(const MeasuredPose<2>& edge, TextLine& line);
Fault put_covariance_point(const MeasuredPoint<2>& point, TextLine& line);

/// The covariance of an information matrix; a fault where that is singular.
template <int Size>
Fault covariance_of(const Matrix<Size>& information, Matrix<Size>& covariance);

/// The information of the covariance that the line gives up to here.
template <int Size>
Matrix<Size> inverse_of(Matrix<Size> covariance, InformationCheck& check, TextScanner& text);

}  // namespace mapjoin
