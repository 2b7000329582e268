! What the library is measured against, in the language its hosts are written in.
!
! Each routine makes one update and is called through a pointer, as the library is; the caller carries the states.
!
!   coulomb_fric    plain Coulomb friction with an elastic slip (standard penalty), as a host's FRIC
!   paper_eq13      the paper's Eq. (13) as it is printed: one direction, fixed origin, no memory of reversals
!   elements_1, _2  the law as n parallel slip elements with radial return, in 1 and 2 directions, proportional rule
!
! Reductions are allowed to be vectorised (-fopenmp-simd); no other licence is taken with rounding.
module rivals
  use, intrinsic :: iso_c_binding, only: dp => c_double, int => c_int
  implicit none
  private

  ! What a point of slip elements remembers: the last ndir arrays are its deflections, over gcr.
  integer, parameter :: pressure_at = 1, stored_at = 2, dissipated_at = 3, header = 3

contains

  ! The paper's Eq. (13) with its tangent.
  ! props: mu, gcr, chi. state: slip from the origin, direction of the last increment, 1 after the first reversal.
  subroutine paper_eq13(slip_increment, pressure, props, state0, state1, traction, dtraction_dslip) bind(c)
    real(dp), intent(in) :: slip_increment, props(3), state0(3)
    real(dp), intent(in), value :: pressure
    real(dp), intent(out) :: state1(3), traction, dtraction_dslip
    real(dp) :: limit, gcr, chi, slip, direction, reversed, rest, power

    limit = props(1) * pressure
    gcr = props(2)
    chi = props(3)
    slip = state0(1) + slip_increment
    direction = state0(2)
    reversed = state0(3)
    if (slip_increment * direction < 0) reversed = 1
    if (slip_increment /= 0) direction = sign(1.0_dp, slip_increment)
    if (abs(slip) >= gcr) then
      traction = sign(limit, slip)
      dtraction_dslip = 0
    else if (reversed == 0) then
      rest = 1 - abs(slip) / gcr
      power = rest**(chi - 1)
      traction = sign(limit * (1 - rest * power), slip)
      dtraction_dslip = limit * chi / gcr * power
    else if (direction < 0) then
      rest = 1 - (gcr - slip) / (2 * gcr)
      power = rest**(chi - 1)
      traction = limit - 2 * limit * (1 - rest * power)
      dtraction_dslip = limit * chi / gcr * power
    else
      rest = 1 - (gcr + slip) / (2 * gcr)
      power = rest**(chi - 1)
      traction = -limit + 2 * limit * (1 - rest * power)
      dtraction_dslip = limit * chi / gcr * power
    end if
    state1(1) = slip
    state1(2) = direction
    state1(3) = reversed
  end subroutine

  ! Slip limits (over gcr) and stiffnesses of n elements. Cells of slip limits in equal parts (grid 0), or so that each end is
  ! the same multiple of the one before, from 1e-3 (grid 1); the stiffness of a cell acts at its centre.
  subroutine elements_setup(n, grid, chi, limit, stiffness) bind(c)
    integer(int), intent(in), value :: n, grid
    real(dp), intent(in), value :: chi
    real(dp), intent(out) :: limit(n), stiffness(n)
    real(dp) :: a, b
    integer :: k

    b = 0
    do k = 1, n
      a = b
      b = real(k, dp) / n
      if (grid == 1) b = 1e-3_dp**(real(n - k, dp) / (n - 1))
      stiffness(k) = slope(a) - slope(b)
      limit(k) = (moment(b) - moment(a)) / stiffness(k)
    end do
  contains
    real(dp) function slope(r)
      real(dp), intent(in) :: r
      slope = chi * (1 - r)**(chi - 1)
    end function
    real(dp) function moment(r)
      real(dp), intent(in) :: r
      moment = 1 - (1 - r)**chi - r * slope(r)
    end function
  end subroutine

  ! Slip elements in one direction. state: 3 + n numbers. energy: stored, dissipated in the increment.
  subroutine elements_1(n, mu, gcr, limit, stiffness, slip_increment, pressure, state0, state1, traction, &
                        dtraction_dslip, dtraction_dpressure, energy) bind(c)
    integer(int), intent(in), value :: n
    real(dp), intent(in), value :: mu, gcr, pressure
    real(dp), intent(in) :: limit(n), stiffness(n), slip_increment, state0(header + n)
    real(dp), intent(out) :: state1(header + n), traction, dtraction_dslip, dtraction_dpressure, energy(2)
    real(dp) :: d, lost, trial, e, excess, t, tangent, stored, dissipated
    integer :: k

    lost = 0
    if (state0(pressure_at) > 0) lost = state0(stored_at) * (1 - pressure / state0(pressure_at))
    d = slip_increment / gcr
    t = 0
    tangent = 0
    stored = 0
    dissipated = 0
    !$omp simd private(trial, e, excess) reduction(+:t, tangent, stored, dissipated)
    do k = 1, n
      trial = state0(header + k) + d
      e = max(-limit(k), min(limit(k), trial))
      excess = abs(trial - e)
      state1(header + k) = e
      t = t + stiffness(k) * e
      stored = stored + stiffness(k) * e * e
      dissipated = dissipated + limit(k) * stiffness(k) * excess
      tangent = tangent + merge(stiffness(k), 0.0_dp, excess == 0)
    end do
    traction = mu * pressure * t
    dtraction_dslip = mu * pressure / gcr * tangent
    dtraction_dpressure = mu * t
    energy(1) = mu * pressure * gcr * stored / 2
    energy(2) = mu * pressure * gcr * dissipated + lost
    state1(pressure_at) = pressure
    state1(stored_at) = energy(1)
    state1(dissipated_at) = state0(dissipated_at) + energy(2)
  end subroutine

  ! Slip elements in two directions. state: 3 + 2 n numbers. dtraction_dslip by columns (it is symmetric).
  subroutine elements_2(n, mu, gcr, limit, stiffness, slip_increment, pressure, state0, state1, traction, &
                        dtraction_dslip, dtraction_dpressure, energy) bind(c)
    integer(int), intent(in), value :: n
    real(dp), intent(in), value :: mu, gcr, pressure
    real(dp), intent(in) :: limit(n), stiffness(n), slip_increment(2), state0(header + 2 * n)
    real(dp), intent(out) :: state1(header + 2 * n), traction(2), dtraction_dslip(2, 2), dtraction_dpressure(2), energy(2)
    real(dp) :: d1, d2, lost, x, y, length2, length, return, turning, s
    real(dp) :: t1, t2, k11, k12, k22, stored, dissipated
    integer :: k

    lost = 0
    if (state0(pressure_at) > 0) lost = state0(stored_at) * (1 - pressure / state0(pressure_at))
    d1 = slip_increment(1) / gcr
    d2 = slip_increment(2) / gcr
    t1 = 0
    t2 = 0
    k11 = 0
    k12 = 0
    k22 = 0
    stored = 0
    dissipated = 0
    !$omp simd private(x, y, length2, length, return, turning, s) &
    !$omp reduction(+:t1, t2, k11, k12, k22, stored, dissipated)
    do k = 1, n
      x = state0(header + k) + d1
      y = state0(header + n + k) + d2
      length2 = x * x + y * y
      length = sqrt(max(length2, limit(k)**2))
      return = limit(k) / length
      x = x * return
      y = y * return
      state1(header + k) = x
      state1(header + n + k) = y
      t1 = t1 + stiffness(k) * x
      t2 = t2 + stiffness(k) * y
      stored = stored + stiffness(k) * (x * x + y * y)
      dissipated = dissipated + limit(k) * stiffness(k) * (length - limit(k))
      ! An element that slips turns on its limit: stiffness r / |trial| (I - n n^T).
      s = stiffness(k) * return
      turning = merge(s / limit(k)**2, 0.0_dp, length2 > limit(k)**2)
      k11 = k11 + s - turning * x * x
      k12 = k12 - turning * x * y
      k22 = k22 + s - turning * y * y
    end do
    traction = mu * pressure * [t1, t2]
    dtraction_dslip(1, 1) = mu * pressure / gcr * k11
    dtraction_dslip(2, 1) = mu * pressure / gcr * k12
    dtraction_dslip(1, 2) = mu * pressure / gcr * k12
    dtraction_dslip(2, 2) = mu * pressure / gcr * k22
    dtraction_dpressure = mu * [t1, t2]
    energy(1) = mu * pressure * gcr * stored / 2
    energy(2) = mu * pressure * gcr * dissipated + lost
    state1(pressure_at) = pressure
    state1(stored_at) = energy(1)
    state1(dissipated_at) = state0(dissipated_at) + energy(2)
  end subroutine

end module

! Coulomb friction with an elastic slip gcr, by radial return. props: mu, gcr. statev: elastic slip per direction.
subroutine coulomb_fric(lm, tau, ddtddg, ddtddp, dslip, sed, sfd, ddtddt, pnewdt, statev, dgam, taulm, press, &
                        dpress, ddpddh, slip, kstep, kinc, time, dtime, noel, ciname, slname, msname, npt, node, &
                        npatch, coords, rcoord, drot, temp, predef, nfdir, mcrd, npred, nstatv, chrlngth, props, &
                        nprops)
  implicit real*8(a-h, o-z)
  character*80 ciname, slname, msname
  dimension tau(nfdir), ddtddg(nfdir, nfdir), ddtddp(nfdir), dslip(nfdir), ddtddt(nfdir, 2), statev(nstatv), &
    dgam(nfdir), taulm(nfdir), slip(nfdir), time(2), coords(mcrd), rcoord(mcrd), drot(2, 2), temp(2), &
    predef(2, npred), props(nprops)

  ddtddt = 0
  if (lm == 2) then
    statev = 0
    return
  end if
  lm = 0
  gcr = props(2)
  stress = props(1) * press
  stiffness = stress / gcr
  if (nfdir == 1) then
    trial = statev(1) + dgam(1)
    elastic = max(-gcr, min(gcr, trial))
    ddtddg(1, 1) = merge(stiffness, 0d0, elastic == trial)
    sfd = stress * abs(trial - elastic)
    sed = stiffness * elastic**2 / 2
    dslip(1) = trial - elastic
    tau(1) = stiffness * elastic
    ddtddp(1) = tau(1) / press
    statev(1) = elastic
    return
  end if
  x = statev(1) + dgam(1)
  y = statev(2) + dgam(2)
  distance = sqrt(x * x + y * y)
  if (distance <= gcr) then
    tau(1) = stiffness * x
    tau(2) = stiffness * y
    ddtddg = 0
    ddtddg(1, 1) = stiffness
    ddtddg(2, 2) = stiffness
    dslip = 0
    sfd = 0
    sed = stiffness * distance**2 / 2
  else
    x = x / distance
    y = y / distance
    tau(1) = stress * x
    tau(2) = stress * y
    turning = stress / distance
    ddtddg(1, 1) = turning * y * y
    ddtddg(2, 2) = turning * x * x
    ddtddg(1, 2) = -turning * x * y
    ddtddg(2, 1) = ddtddg(1, 2)
    sfd = stress * (distance - gcr)
    sed = stress * gcr / 2
    dslip(1) = (distance - gcr) * x
    dslip(2) = (distance - gcr) * y
    x = gcr * x
    y = gcr * y
  end if
  ddtddp(1) = tau(1) / press
  ddtddp(2) = tau(2) / press
  statev(1) = x
  statev(2) = y
end subroutine
