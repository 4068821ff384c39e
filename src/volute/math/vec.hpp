// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <cmath>
#include <concepts>
#include <cstddef>
#include <iosfwd>
#include <limits>
#include <type_traits>

namespace volute {

namespace detail {

/// What Eigen calls a matrix or an array of that size, or an expression of one; told by its
/// members, so that its headers need not be read.
template <class E, int Rows, int Columns>
concept EigenOfSize = requires(const E& e) {
  typename E::PlainObject;
  e.derived().coeff(0, 0);
} && int{E::RowsAtCompileTime} == Rows && int{E::ColsAtCompileTime} == Columns;

/// What vectors and arrays of N numbers have in common: they are N numbers and nothing else,
/// whatever a compiler is told of alignment. Functions are named as Eigen's. A default-constructed
/// one holds no particular numbers. Sums go from the first to the last.
template <class Self, class T, int N>
class Numbers {
 public:
  using Scalar = T;
  static constexpr int kSize = N;

  constexpr Numbers() = default;

  template <class... Values>
    requires(N > 1 && sizeof...(Values) == N && (std::convertible_to<Values, T> && ...))
  constexpr Numbers(Values... values) : numbers_{static_cast<T>(values)...} {}

  static constexpr Self Constant(T value) {
    Self all;
    for (T& x : all) x = value;
    return all;
  }

  static constexpr Self Zero() { return Constant(T(0)); }

  static constexpr Self Ones() { return Constant(T(1)); }

  /// The N numbers at `from`.
  constexpr explicit Numbers(const T* from) {
    for (int i = 0; i < N; ++i) numbers_[i] = from[i];
  }

  constexpr T& operator[](std::integral auto i) { return numbers_[i]; }

  constexpr const T& operator[](std::integral auto i) const { return numbers_[i]; }

  constexpr T& operator()(std::integral auto i) { return numbers_[i]; }

  constexpr const T& operator()(std::integral auto i) const { return numbers_[i]; }

  constexpr T& x() { return numbers_[0]; }

  constexpr T& y() { return numbers_[1]; }

  constexpr T& z()
    requires(N > 2)
  {
    return numbers_[2];
  }

  constexpr const T& x() const { return numbers_[0]; }

  constexpr const T& y() const { return numbers_[1]; }

  constexpr const T& z() const
    requires(N > 2)
  {
    return numbers_[2];
  }

  constexpr T* data() { return numbers_; }

  constexpr const T* data() const { return numbers_; }

  constexpr T* begin() { return numbers_; }

  constexpr T* end() { return numbers_ + N; }

  constexpr const T* begin() const { return numbers_; }

  constexpr const T* end() const { return numbers_ + N; }

  static constexpr int size() { return N; }

  constexpr T sum() const {
    T total = numbers_[0];
    for (int i = 1; i < N; ++i) total += numbers_[i];
    return total;
  }

  constexpr T prod() const {
    T total = numbers_[0];
    for (int i = 1; i < N; ++i) total *= numbers_[i];
    return total;
  }

  constexpr T mean() const { return sum() / T(N); }

  constexpr T minCoeff() const {
    T least = numbers_[0];
    for (int i = 1; i < N; ++i) least = numbers_[i] < least ? numbers_[i] : least;
    return least;
  }

  constexpr T maxCoeff() const {
    T most = numbers_[0];
    for (int i = 1; i < N; ++i) most = most < numbers_[i] ? numbers_[i] : most;
    return most;
  }

  /// And which number it is; the first of several.
  constexpr T maxCoeff(std::integral auto* which) const {
    *which = 0;
    for (int i = 1; i < N; ++i)
      if (numbers_[*which] < numbers_[i])
        *which = i;
    return numbers_[*which];
  }

  constexpr T minCoeff(std::integral auto* which) const {
    *which = 0;
    for (int i = 1; i < N; ++i)
      if (numbers_[i] < numbers_[*which])
        *which = i;
    return numbers_[*which];
  }

  bool allFinite() const {
    for (const T x : numbers_)
      if (!std::isfinite(x))
        return false;
    return true;
  }

  bool isZero(T precision = T(1e-12)) const {
    for (const T x : numbers_)
      if (!(std::abs(x) <= precision))
        return false;
    return true;
  }

  bool isConstant(T value, T precision = T(1e-12)) const {
    for (const T x : numbers_)
      if (!(std::abs(x - value) <= precision * std::fmin(std::abs(x), std::abs(value))))
        return false;
    return true;
  }

  constexpr void fill(T value) {
    for (T& x : numbers_) x = value;
  }

  constexpr void setConstant(T value) { fill(value); }

  constexpr void setZero() { fill(T(0)); }

  template <class F>
  constexpr Self unaryExpr(F&& f) const {
    Self result;
    for (int i = 0; i < N; ++i) result[i] = f(numbers_[i]);
    return result;
  }

  constexpr Self operator-() const {
    return unaryExpr([](T x) { return -x; });
  }

  constexpr Self& operator+=(const Self& other) {
    for (int i = 0; i < N; ++i) numbers_[i] += other[i];
    return self();
  }

  constexpr Self& operator-=(const Self& other) {
    for (int i = 0; i < N; ++i) numbers_[i] -= other[i];
    return self();
  }

  constexpr Self& operator*=(T factor) {
    for (T& x : numbers_) x *= factor;
    return self();
  }

  constexpr Self& operator/=(T divisor) {
    for (T& x : numbers_) x /= divisor;
    return self();
  }

  friend constexpr Self operator+(Self a, const Self& b) { return a += b; }

  friend constexpr Self operator-(Self a, const Self& b) { return a -= b; }

  friend constexpr Self operator*(Self a, T factor) { return a *= factor; }

  friend constexpr Self operator*(T factor, Self a) { return a *= factor; }

  friend constexpr Self operator/(Self a, T divisor) { return a /= divisor; }

  /// "1 2 3".
  template <class Char, class Traits>
  friend std::basic_ostream<Char, Traits>& operator<<(std::basic_ostream<Char, Traits>& out,
                                                      const Self& numbers) {
    for (int i = 0; i < N; ++i) out << (i > 0 ? " " : "") << numbers[i];
    return out;
  }

 protected:
  constexpr Self& self() { return static_cast<Self&>(*this); }

  template <class F>
  static constexpr Self combined(const Numbers& a, const Numbers& b, F&& f) {
    Self result;
    for (int i = 0; i < N; ++i) result[i] = f(a[i], b[i]);
    return result;
  }

  static constexpr T lesser(T a, T b) { return b < a ? b : a; }

  static constexpr T greater(T a, T b) { return a < b ? b : a; }

  T numbers_[N];
};

}  // namespace detail

template <class T, int N>
class ArrayN;
template <class T, int Rows, int Columns>
class MatN;

/// A vector of N numbers, with the functions of linear algebra.
template <class T, int N>
class VecN : public detail::Numbers<VecN<T, N>, T, N> {
  using Base = detail::Numbers<VecN, T, N>;

 public:
  using Base::Base;

  constexpr VecN() = default;

  template <detail::EigenOfSize<N, 1> E>
  VecN(const E& e) {
    const typename E::PlainObject plain(e);
    for (int i = 0; i < N; ++i) (*this)[i] = plain.coeff(i, 0);
  }

  constexpr explicit VecN(const ArrayN<T, N>& numbers) : VecN(numbers.data()) {}

  static constexpr VecN Unit(int axis) {
    VecN unit = VecN::Zero();
    unit[axis] = 1;
    return unit;
  }

  static constexpr VecN UnitX() { return Unit(0); }

  static constexpr VecN UnitY() { return Unit(1); }

  static constexpr VecN UnitZ() { return Unit(2); }

  constexpr bool operator==(const VecN& other) const {
    for (int i = 0; i < N; ++i)
      if (!((*this)[i] == other[i]))
        return false;
    return true;
  }

  constexpr T dot(const VecN& other) const { return cwiseProduct(other).sum(); }

  constexpr VecN cross(const VecN& b) const
    requires(N == 3)
  {
    const VecN& a = *this;
    return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
  }

  constexpr T squaredNorm() const { return dot(*this); }

  T norm() const { return std::sqrt(squaredNorm()); }

  /// Zero stays as it is.
  VecN normalized() const {
    const T squared = squaredNorm();
    return squared > 0 ? *this / std::sqrt(squared) : *this;
  }

  void normalize() { *this = normalized(); }

  /// Some direction at a right angle to this one.
  VecN unitOrthogonal() const
    requires(N == 3)
  {
    const VecN& a = *this;
    const T small = std::abs(a[2]) * T(1e-12);
    if (std::abs(a[0]) > small || std::abs(a[1]) > small) {
      const T scale = 1 / std::sqrt(a[0] * a[0] + a[1] * a[1]);
      return {-a[1] * scale, a[0] * scale, 0};
    }
    const T scale = 1 / std::sqrt(a[1] * a[1] + a[2] * a[2]);
    return {0, -a[2] * scale, a[1] * scale};
  }

  constexpr VecN cwiseProduct(const VecN& b) const {
    return Base::combined(*this, b, [](T x, T y) { return x * y; });
  }

  constexpr VecN cwiseQuotient(const VecN& b) const {
    return Base::combined(*this, b, [](T x, T y) { return x / y; });
  }

  constexpr VecN cwiseMin(const VecN& b) const { return Base::combined(*this, b, Base::lesser); }

  constexpr VecN cwiseMax(const VecN& b) const { return Base::combined(*this, b, Base::greater); }

  constexpr VecN cwiseMin(T b) const { return cwiseMin(VecN::Constant(b)); }

  constexpr VecN cwiseMax(T b) const { return cwiseMax(VecN::Constant(b)); }

  constexpr VecN cwiseAbs() const {
    return this->unaryExpr([](T x) { return std::abs(x); });
  }

  constexpr VecN cwiseInverse() const {
    return this->unaryExpr([](T x) { return 1 / x; });
  }

  bool isApprox(const VecN& b, T precision = T(1e-12)) const {
    return (*this - b).squaredNorm() <=
           precision * precision * Base::lesser(squaredNorm(), b.squaredNorm());
  }

  template <class To>
  constexpr VecN<To, N> cast() const {
    VecN<To, N> result;
    for (int i = 0; i < N; ++i) result[i] = static_cast<To>((*this)[i]);
    return result;
  }

  /// Count numbers from the first-th on. A copy: const, lest somebody assign to it.
  template <int Count>
  constexpr const VecN<T, Count> segment(int first) const {
    return VecN<T, Count>(this->data() + first);
  }

  template <int Count>
  constexpr const VecN<T, Count> head() const {
    return segment<Count>(0);
  }

  template <int Count>
  constexpr const VecN<T, Count> tail() const {
    return segment<Count>(N - Count);
  }

  constexpr const ArrayN<T, N> array() const;  ///< a copy

  /// The matrix that scales by these along the axes.
  constexpr const MatN<T, N, N> asDiagonal() const;
};

/// N numbers, one by one: products, quotients and comparisons are those of each.
template <class T, int N>
class ArrayN : public detail::Numbers<ArrayN<T, N>, T, N> {
  using Base = detail::Numbers<ArrayN, T, N>;
  using Bools = ArrayN<bool, N>;

 public:
  using Base::Base;
  using Base::operator*=;
  using Base::operator/=;

  constexpr ArrayN() = default;

  template <detail::EigenOfSize<N, 1> E>
  ArrayN(const E& e) {
    const typename E::PlainObject plain(e);
    for (int i = 0; i < N; ++i) (*this)[i] = plain.coeff(i, 0);
  }

  constexpr explicit ArrayN(const VecN<T, N>& numbers) : ArrayN(numbers.data()) {}

  constexpr ArrayN& operator*=(const ArrayN& b) {
    for (int i = 0; i < N; ++i) (*this)[i] *= b[i];
    return *this;
  }

  constexpr ArrayN& operator/=(const ArrayN& b) {
    for (int i = 0; i < N; ++i) (*this)[i] /= b[i];
    return *this;
  }

  constexpr ArrayN& operator+=(const ArrayN& b) { return Base::operator+=(b); }

  constexpr ArrayN& operator-=(const ArrayN& b) { return Base::operator-=(b); }

  constexpr ArrayN& operator+=(T b) { return *this += ArrayN::Constant(b); }

  constexpr ArrayN& operator-=(T b) { return *this -= ArrayN::Constant(b); }

  friend constexpr ArrayN operator*(ArrayN a, const ArrayN& b) { return a *= b; }

  friend constexpr ArrayN operator/(ArrayN a, const ArrayN& b) { return a /= b; }

  friend constexpr ArrayN operator+(ArrayN a, T b) { return a += b; }

  friend constexpr ArrayN operator+(T b, ArrayN a) { return a += b; }

  friend constexpr ArrayN operator-(ArrayN a, T b) { return a -= b; }

  friend constexpr ArrayN operator-(T a, const ArrayN& b) { return ArrayN::Constant(a) - b; }

  friend constexpr ArrayN operator/(T a, const ArrayN& b) { return ArrayN::Constant(a) / b; }

  friend constexpr Bools operator<(const ArrayN& a, const ArrayN& b) {
    return compared(a, b, [](T x, T y) { return x < y; });
  }

  friend constexpr Bools operator<=(const ArrayN& a, const ArrayN& b) {
    return compared(a, b, [](T x, T y) { return x <= y; });
  }

  friend constexpr Bools operator==(const ArrayN& a, const ArrayN& b) {
    return compared(a, b, [](T x, T y) { return x == y; });
  }

  friend constexpr Bools operator!=(const ArrayN& a, const ArrayN& b) {
    return compared(a, b, [](T x, T y) { return x != y; });
  }

  friend constexpr Bools operator>(const ArrayN& a, const ArrayN& b) { return b < a; }

  friend constexpr Bools operator>=(const ArrayN& a, const ArrayN& b) { return b <= a; }

  friend constexpr Bools operator<(const ArrayN& a, T b) { return a < ArrayN::Constant(b); }

  friend constexpr Bools operator<=(const ArrayN& a, T b) { return a <= ArrayN::Constant(b); }

  friend constexpr Bools operator>(const ArrayN& a, T b) { return ArrayN::Constant(b) < a; }

  friend constexpr Bools operator>=(const ArrayN& a, T b) { return ArrayN::Constant(b) <= a; }

  friend constexpr Bools operator==(const ArrayN& a, T b) { return a == ArrayN::Constant(b); }

  friend constexpr Bools operator!=(const ArrayN& a, T b) { return a != ArrayN::Constant(b); }

  constexpr bool all() const
    requires std::same_as<T, bool>
  {
    return count() == N;
  }

  constexpr bool any() const
    requires std::same_as<T, bool>
  {
    return count() > 0;
  }

  constexpr int count() const
    requires std::same_as<T, bool>
  {
    int many = 0;
    for (const bool is : *this) many += is ? 1 : 0;
    return many;
  }

  constexpr ArrayN operator&&(const ArrayN& b) const
    requires std::same_as<T, bool>
  {
    return Base::combined(*this, b, [](bool x, bool y) { return x && y; });
  }

  constexpr ArrayN min(const ArrayN& b) const { return Base::combined(*this, b, Base::lesser); }

  constexpr ArrayN max(const ArrayN& b) const { return Base::combined(*this, b, Base::greater); }

  constexpr ArrayN min(T b) const { return min(ArrayN::Constant(b)); }

  constexpr ArrayN max(T b) const { return max(ArrayN::Constant(b)); }

  constexpr ArrayN abs() const {
    return this->unaryExpr([](T x) { return std::abs(x); });
  }

  constexpr ArrayN square() const { return *this * *this; }

  ArrayN sqrt() const {
    return this->unaryExpr([](T x) { return std::sqrt(x); });
  }

  ArrayN exp() const {
    return this->unaryExpr([](T x) { return std::exp(x); });
  }

  ArrayN log() const {
    return this->unaryExpr([](T x) { return std::log(x); });
  }

  ArrayN pow(T power) const {
    return this->unaryExpr([power](T x) { return std::pow(x, power); });
  }

  ArrayN floor() const {
    return this->unaryExpr([](T x) { return std::floor(x); });
  }

  ArrayN ceil() const {
    return this->unaryExpr([](T x) { return std::ceil(x); });
  }

  Bools isFinite() const {
    Bools result;
    for (int i = 0; i < N; ++i) result[i] = std::isfinite((*this)[i]);
    return result;
  }

  ArrayN round() const {
    return this->unaryExpr([](T x) { return std::round(x); });
  }

  constexpr ArrayN inverse() const {
    return this->unaryExpr([](T x) { return 1 / x; });
  }

  bool isApprox(const ArrayN& b, T precision = T(1e-12)) const {
    return matrix().isApprox(b.matrix(), precision);
  }

  template <class To>
  constexpr ArrayN<To, N> cast() const {
    ArrayN<To, N> result;
    for (int i = 0; i < N; ++i) result[i] = static_cast<To>((*this)[i]);
    return result;
  }

  template <int Count>
  constexpr const ArrayN<T, Count> head() const {
    return ArrayN<T, Count>(this->data());
  }

  constexpr const VecN<T, N> matrix() const { return VecN<T, N>(this->data()); }  ///< a copy

 private:
  template <class F>
  static constexpr Bools compared(const ArrayN& a, const ArrayN& b, F&& f) {
    Bools result;
    for (int i = 0; i < N; ++i) result[i] = f(a[i], b[i]);
    return result;
  }
};

template <class T, int N>
constexpr const ArrayN<T, N> VecN<T, N>::array() const {
  return ArrayN<T, N>(this->data());
}

/// A matrix: its columns.
template <class T, int Rows, int Columns>
class MatN {
 public:
  using Scalar = T;
  using Column = VecN<T, Rows>;
  using Row = VecN<T, Columns>;

  constexpr MatN() = default;

  /// All numbers, row by row.
  template <class... Values>
    requires(sizeof...(Values) == Rows * Columns && (std::convertible_to<Values, T> && ...))
  constexpr MatN(Values... values) {
    const T numbers[Rows * Columns] = {static_cast<T>(values)...};
    for (int i = 0; i < Rows * Columns; ++i) (*this)(i / Columns, i % Columns) = numbers[i];
  }

  /// Numbers column by column.
  constexpr explicit MatN(const T* from) {
    for (int c = 0; c < Columns; ++c) columns_[c] = Column(from + Rows * c);
  }

  template <detail::EigenOfSize<Rows, Columns> E>
  MatN(const E& e) {
    const typename E::PlainObject plain(e);
    for (int c = 0; c < Columns; ++c)
      for (int r = 0; r < Rows; ++r) (*this)(r, c) = plain.coeff(r, c);
  }

  template <class... Columns_>
    requires(sizeof...(Columns_) == Columns && (std::convertible_to<Columns_, Column> && ...))
  static constexpr MatN ofColumns(const Columns_&... columns) {
    MatN matrix;
    int c = 0;
    ((matrix.columns_[c++] = columns), ...);
    return matrix;
  }

  template <class... Rows_>
    requires(sizeof...(Rows_) == Rows && (std::convertible_to<Rows_, Row> && ...))
  static constexpr MatN ofRows(const Rows_&... rows) {
    return MatN<T, Columns, Rows>::ofColumns(rows...).transpose();
  }

  static constexpr MatN Constant(T value) {
    MatN all;
    for (Column& column : all.columns_) column.fill(value);
    return all;
  }

  static constexpr MatN Zero() { return Constant(T(0)); }

  static constexpr MatN Identity() {
    MatN one = Zero();
    for (int i = 0; i < (Rows < Columns ? Rows : Columns); ++i) one(i, i) = 1;
    return one;
  }

  constexpr T& operator()(std::integral auto row, std::integral auto column) {
    return columns_[column][row];
  }

  constexpr const T& operator()(std::integral auto row, std::integral auto column) const {
    return columns_[column][row];
  }

  constexpr Column& col(std::integral auto column) { return columns_[column]; }

  constexpr const Column& col(std::integral auto column) const { return columns_[column]; }

  /// A copy: const, lest somebody assign to it.
  constexpr const Row row(std::integral auto row) const {
    Row numbers;
    for (int c = 0; c < Columns; ++c) numbers[c] = columns_[c][row];
    return numbers;
  }

  /// The length of each column.
  constexpr Row columnNorms() const {
    Row norms;
    for (int c = 0; c < Columns; ++c) norms[c] = columns_[c].norm();
    return norms;
  }

  constexpr const Column diagonal() const
    requires(Rows == Columns)
  {
    Column numbers;
    for (int i = 0; i < Rows; ++i) numbers[i] = columns_[i][i];
    return numbers;
  }

  constexpr T* data() { return columns_[0].data(); }  ///< column by column

  constexpr const T* data() const { return columns_[0].data(); }

  static constexpr int size() { return Rows * Columns; }

  constexpr bool operator==(const MatN&) const = default;

  constexpr MatN<T, Columns, Rows> transpose() const {
    MatN<T, Columns, Rows> turned;
    for (int c = 0; c < Columns; ++c)
      for (int r = 0; r < Rows; ++r) turned(c, r) = (*this)(r, c);
    return turned;
  }

  constexpr MatN& operator+=(const MatN& b) {
    for (int c = 0; c < Columns; ++c) columns_[c] += b.columns_[c];
    return *this;
  }

  constexpr MatN& operator-=(const MatN& b) {
    for (int c = 0; c < Columns; ++c) columns_[c] -= b.columns_[c];
    return *this;
  }

  constexpr MatN& operator*=(T factor) {
    for (Column& column : columns_) column *= factor;
    return *this;
  }

  constexpr MatN& operator/=(T divisor) {
    for (Column& column : columns_) column /= divisor;
    return *this;
  }

  constexpr MatN operator-() const { return MatN(*this) *= T(-1); }

  friend constexpr MatN operator+(MatN a, const MatN& b) { return a += b; }

  friend constexpr MatN operator-(MatN a, const MatN& b) { return a -= b; }

  friend constexpr MatN operator*(MatN a, T factor) { return a *= factor; }

  friend constexpr MatN operator*(T factor, MatN a) { return a *= factor; }

  friend constexpr MatN operator/(MatN a, T divisor) { return a /= divisor; }

  constexpr Column operator*(const Row& b) const {
    Column sum = columns_[0] * b[0];
    for (int c = 1; c < Columns; ++c) sum += columns_[c] * b[c];
    return sum;
  }

  template <int Others>
  constexpr MatN<T, Rows, Others> operator*(const MatN<T, Columns, Others>& b) const {
    MatN<T, Rows, Others> product;
    for (int c = 0; c < Others; ++c) product.col(c) = *this * b.col(c);
    return product;
  }

  template <class F>
  constexpr MatN unaryExpr(F&& f) const {
    MatN result;
    for (int c = 0; c < Columns; ++c) result.columns_[c] = columns_[c].unaryExpr(f);
    return result;
  }

  constexpr MatN cwiseAbs() const {
    return unaryExpr([](T x) { return std::abs(x); });
  }

  constexpr T maxCoeff() const {
    T most = columns_[0].maxCoeff();
    for (const Column& column : columns_)
      most = most < column.maxCoeff() ? column.maxCoeff() : most;
    return most;
  }

  constexpr T minCoeff() const {
    T least = columns_[0].minCoeff();
    for (const Column& column : columns_)
      least = column.minCoeff() < least ? column.minCoeff() : least;
    return least;
  }

  constexpr T sum() const {
    T total = columns_[0].sum();
    for (int c = 1; c < Columns; ++c) total += columns_[c].sum();
    return total;
  }

  constexpr T trace() const
    requires(Rows == Columns)
  {
    return diagonal().sum();
  }

  constexpr T squaredNorm() const {
    T total = columns_[0].squaredNorm();
    for (int c = 1; c < Columns; ++c) total += columns_[c].squaredNorm();
    return total;
  }

  T norm() const { return std::sqrt(squaredNorm()); }

  bool allFinite() const {
    for (const Column& column : columns_)
      if (!column.allFinite())
        return false;
    return true;
  }

  bool isApprox(const MatN& b, T precision = T(1e-12)) const {
    const T a2 = squaredNorm(), b2 = b.squaredNorm();
    return (*this - b).squaredNorm() <= precision * precision * (b2 < a2 ? b2 : a2);
  }

  bool isIdentity(T precision = T(1e-12)) const {
    for (int c = 0; c < Columns; ++c)
      for (int r = 0; r < Rows; ++r)
        if (!(std::abs((*this)(r, c) - (r == c ? 1 : 0)) <= precision))
          return false;
    return true;
  }

  /// A line for each row.
  template <class Char, class Traits>
  friend std::basic_ostream<Char, Traits>& operator<<(std::basic_ostream<Char, Traits>& out,
                                                      const MatN& matrix) {
    for (int r = 0; r < Rows; ++r) out << (r > 0 ? "\n" : "") << matrix.row(r);
    return out;
  }

  constexpr T determinant() const
    requires(Rows == 2 && Columns == 2)
  {
    const MatN& m = *this;
    return m(0, 0) * m(1, 1) - m(1, 0) * m(0, 1);
  }

  constexpr T determinant() const
    requires(Rows == 3 && Columns == 3)
  {
    const MatN& m = *this;
    const auto part = [&](int a, int b, int c) {
      return m(0, a) * (m(1, b) * m(2, c) - m(1, c) * m(2, b));
    };
    return part(0, 1, 2) - part(1, 0, 2) + part(2, 0, 1);
  }

  /// By cofactors; not finite where the determinant is 0.
  constexpr MatN inverse() const
    requires(Rows == 2 && Columns == 2)
  {
    const MatN& m = *this;
    const T scale = 1 / determinant();
    return {m(1, 1) * scale, -m(0, 1) * scale, -m(1, 0) * scale, m(0, 0) * scale};
  }

  constexpr MatN inverse() const
    requires(Rows == 3 && Columns == 3)
  {
    const MatN& m = *this;
    const auto cofactor = [&](int i, int j) {
      const int i1 = (i + 1) % 3, i2 = (i + 2) % 3, j1 = (j + 1) % 3, j2 = (j + 2) % 3;
      return m(i1, j1) * m(i2, j2) - m(i1, j2) * m(i2, j1);
    };
    const Column first(cofactor(0, 0), cofactor(1, 0), cofactor(2, 0));
    const T scale = 1 / first.dot(m.col(0));
    MatN result;
    for (int r = 0; r < 3; ++r)
      for (int c = 0; c < 3; ++c) result(r, c) = (r == 0 ? first[c] : cofactor(c, r)) * scale;
    return result;
  }

  template <class To>
  constexpr MatN<To, Rows, Columns> cast() const {
    MatN<To, Rows, Columns> result;
    for (int c = 0; c < Columns; ++c) result.col(c) = columns_[c].template cast<To>();
    return result;
  }

 private:
  Column columns_[Columns];
};

/// a b'.
template <class T, int Rows, int Columns>
constexpr MatN<T, Rows, Columns> outerProduct(const VecN<T, Rows>& a, const VecN<T, Columns>& b) {
  MatN<T, Rows, Columns> product;
  for (int c = 0; c < Columns; ++c) product.col(c) = a * b[c];
  return product;
}

template <class T, int N>
constexpr const MatN<T, N, N> VecN<T, N>::asDiagonal() const {
  MatN<T, N, N> matrix = MatN<T, N, N>::Zero();
  for (int i = 0; i < N; ++i) matrix(i, i) = (*this)[i];
  return matrix;
}

/// Points and directions in the world [m] unless a name says otherwise (pointInVoxels,
/// pointInCamera).
using Vec3 = VecN<double, 3>;
using Vec4 = VecN<double, 4>;
using Mat2 = MatN<double, 2, 2>;
using Mat3 = MatN<double, 3, 3>;
using Mat4 = MatN<double, 4, 4>;

/// A point of a plane: of an image [pixels], or of a floor [m].
using Vec2 = VecN<double, 2>;

/// Linear RGB: radiance, or whatever a comment says.
using Rgb = ArrayN<double, 3>;

/// x -> linear x + offset, and its parts.
constexpr Mat4 affine(const Mat3& linear, const Vec3& offset) {
  Mat4 matrix = Mat4::Identity();
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 3; ++c) matrix(r, c) = linear(r, c);
    matrix(r, 3) = offset[r];
  }
  return matrix;
}

constexpr const Mat3 linearPart(const Mat4& matrix) {
  return Mat3::ofColumns(matrix.col(0).head<3>(), matrix.col(1).head<3>(), matrix.col(2).head<3>());
}

constexpr const Vec3 offsetPart(const Mat4& matrix) {
  return matrix.col(3).head<3>();
}

}  // namespace volute
