! What the library is measured against, in the language its hosts are written in.
!
! Each routine makes one update and is called through a pointer, as the library is; the caller carries the states.
!
!   coulomb_fric    plain Coulomb friction with an elastic slip (standard penalty), as a host's FRIC
!   paper_eq13      the paper's Eq. (13) as it is printed: one direction, fixed origin, no memory of reversals
!   elements_1, _2  the law as 16 parallel slip elements with radial return, in 1 and 2 directions
!
! Reductions are allowed to be vectorised (-fopenmp-simd); no other licence is taken with rounding.
module rivals
  use, intrinsic :: iso_c_binding, only: dp => c_double
  implicit none
  private

  integer, parameter :: elements = 16

  ! What the slip elements need to know; made once by elements_setup.
  type, bind(c) :: element_law
    real(dp) :: mu, gcr
    real(dp), dimension(elements) :: limit, limit2, stiffness, limit_stiffness, stiffness_per_limit2
  end type

  ! What a point of slip elements remembers: the last ndir arrays are its deflections.
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

  ! Elements of equal error: the ends of their cells share out the integral of sqrt(-f''), the stiffness of a
  ! cell acts at its centre.
  subroutine elements_setup(mu, gcr, chi, law) bind(c)
    real(dp), intent(in), value :: mu, gcr, chi
    type(element_law), intent(out) :: law
    real(dp) :: a, b
    integer :: k

    law%mu = mu
    law%gcr = gcr
    b = 0
    do k = 1, elements
      a = b
      b = 1 - (1 - real(k, dp) / elements)**(2 / chi)
      law%stiffness(k) = slope(a) - slope(b)
      law%limit(k) = (moment(b) - moment(a)) / law%stiffness(k)
    end do
    law%limit2 = law%limit**2
    law%limit_stiffness = law%limit * law%stiffness
    law%stiffness_per_limit2 = law%stiffness / law%limit2
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

  ! What the elements keep of their deflections when the pressure changes, and the energy that goes with the rest.
  ! New stiffness arrives unloaded; a virgin or open point has nothing to lose.
  pure subroutine change_pressure(pressure, before, stored, scale, lost)
    real(dp), intent(in) :: pressure, before, stored
    real(dp), intent(out) :: scale, lost

    scale = 1
    lost = 0
    if (before <= 0) return
    if (pressure > before) then
      scale = before / pressure
      lost = stored * (1 - scale)
    else
      lost = stored * (1 - pressure / before)
    end if
  end subroutine

  ! Slip elements in one direction. state: 3 + 16 numbers. energy: stored, dissipated in the increment.
  subroutine elements_1(law, slip_increment, pressure, state0, state1, traction, dtraction_dslip, &
                        dtraction_dpressure, energy) bind(c)
    type(element_law), intent(in) :: law
    real(dp), intent(in), value :: pressure
    real(dp), intent(in) :: slip_increment, state0(header + elements)
    real(dp), intent(out) :: state1(header + elements), traction, dtraction_dslip, dtraction_dpressure, energy(2)
    real(dp) :: d, scale, lost, trial, e, excess, t, tangent, stored, dissipated, shrinkage, limit
    integer :: k

    if (pressure <= 0) then
      traction = 0
      dtraction_dslip = 0
      dtraction_dpressure = 0
      energy = [0.0_dp, state0(stored_at)]
      state1 = 0
      state1(dissipated_at) = state0(dissipated_at) + energy(2)
      return
    end if
    call change_pressure(pressure, state0(pressure_at), state0(stored_at), scale, lost)
    d = slip_increment / law%gcr
    t = 0
    tangent = 0
    stored = 0
    dissipated = 0
    !$omp simd private(trial, e, excess) reduction(+:t, tangent, stored, dissipated)
    do k = 1, elements
      trial = state0(header + k) * scale + d
      e = max(-law%limit(k), min(law%limit(k), trial))
      excess = abs(trial - e)
      state1(header + k) = e
      t = t + law%stiffness(k) * e
      stored = stored + law%stiffness(k) * e * e
      dissipated = dissipated + law%limit_stiffness(k) * excess
      tangent = tangent + merge(law%stiffness(k), 0.0_dp, excess == 0)
    end do
    shrinkage = 0
    if (scale < 1) then
      !$omp simd private(trial) reduction(+:shrinkage)
      do k = 1, elements
        trial = state0(header + k) * scale
        shrinkage = shrinkage + merge(law%stiffness(k) * trial, 0.0_dp, abs(trial + d) <= law%limit(k))
      end do
    end if
    limit = law%mu * pressure
    traction = limit * t
    dtraction_dslip = limit / law%gcr * tangent
    dtraction_dpressure = law%mu * (t - shrinkage)
    energy(1) = limit * law%gcr * stored / 2
    energy(2) = limit * law%gcr * dissipated + lost
    state1(pressure_at) = pressure
    state1(stored_at) = energy(1)
    state1(dissipated_at) = state0(dissipated_at) + energy(2)
  end subroutine

  ! Slip elements in two directions. state: 3 + 2 x 16 numbers. dtraction_dslip by columns (it is symmetric).
  subroutine elements_2(law, slip_increment, pressure, state0, state1, traction, dtraction_dslip, &
                        dtraction_dpressure, energy) bind(c)
    type(element_law), intent(in) :: law
    real(dp), intent(in), value :: pressure
    real(dp), intent(in) :: slip_increment(2), state0(header + 2 * elements)
    real(dp), intent(out) :: state1(header + 2 * elements), traction(2), dtraction_dslip(2, 2), &
      dtraction_dpressure(2), energy(2)
    integer, parameter :: one = header, two = header + elements
    real(dp) :: d1, d2, scale, lost, x, y, length2, length, return, turning, stiffness
    real(dp) :: t1, t2, k11, k12, k22, stored, dissipated, shrinkage1, shrinkage2, limit
    integer :: k

    if (pressure <= 0) then
      traction = 0
      dtraction_dslip = 0
      dtraction_dpressure = 0
      energy = [0.0_dp, state0(stored_at)]
      state1 = 0
      state1(dissipated_at) = state0(dissipated_at) + energy(2)
      return
    end if
    call change_pressure(pressure, state0(pressure_at), state0(stored_at), scale, lost)
    d1 = slip_increment(1) / law%gcr
    d2 = slip_increment(2) / law%gcr
    t1 = 0
    t2 = 0
    k11 = 0
    k12 = 0
    k22 = 0
    stored = 0
    dissipated = 0
    !$omp simd private(x, y, length2, length, return, turning, stiffness) &
    !$omp reduction(+:t1, t2, k11, k12, k22, stored, dissipated)
    do k = 1, elements
      x = state0(one + k) * scale + d1
      y = state0(two + k) * scale + d2
      length2 = x * x + y * y
      length = sqrt(max(length2, law%limit2(k)))
      return = law%limit(k) / length
      x = x * return
      y = y * return
      state1(one + k) = x
      state1(two + k) = y
      t1 = t1 + law%stiffness(k) * x
      t2 = t2 + law%stiffness(k) * y
      stored = stored + law%stiffness(k) * (x * x + y * y)
      dissipated = dissipated + law%limit_stiffness(k) * (length - law%limit(k))
      ! An element that slips turns on its limit: stiffness r / |trial| (I - n n^T).
      stiffness = law%stiffness(k) * return
      turning = merge(law%stiffness_per_limit2(k), 0.0_dp, length2 > law%limit2(k)) * return
      k11 = k11 + stiffness - turning * x * x
      k12 = k12 - turning * x * y
      k22 = k22 + stiffness - turning * y * y
    end do
    shrinkage1 = 0
    shrinkage2 = 0
    if (scale < 1) call shrink(law, scale, [d1, d2], state0, shrinkage1, shrinkage2)
    limit = law%mu * pressure
    traction(1) = limit * t1
    traction(2) = limit * t2
    dtraction_dslip(1, 1) = limit / law%gcr * k11
    dtraction_dslip(2, 1) = limit / law%gcr * k12
    dtraction_dslip(1, 2) = limit / law%gcr * k12
    dtraction_dslip(2, 2) = limit / law%gcr * k22
    dtraction_dpressure(1) = law%mu * (t1 - shrinkage1)
    dtraction_dpressure(2) = law%mu * (t2 - shrinkage2)
    energy(1) = limit * law%gcr * stored / 2
    energy(2) = limit * law%gcr * dissipated + lost
    state1(pressure_at) = pressure
    state1(stored_at) = energy(1)
    state1(dissipated_at) = state0(dissipated_at) + energy(2)
  end subroutine

  ! What the traction loses because the old deflections shrink under a rising pressure.
  subroutine shrink(law, scale, d, state0, shrinkage1, shrinkage2)
    type(element_law), intent(in) :: law
    real(dp), intent(in) :: scale, d(2), state0(header + 2 * elements)
    real(dp), intent(out) :: shrinkage1, shrinkage2
    real(dp) :: e1, e2, x, y, length2, along, return
    integer :: k

    shrinkage1 = 0
    shrinkage2 = 0
    !$omp simd private(e1, e2, x, y, length2, along, return) reduction(+:shrinkage1, shrinkage2)
    do k = 1, elements
      e1 = state0(header + k) * scale
      e2 = state0(header + elements + k) * scale
      x = e1 + d(1)
      y = e2 + d(2)
      length2 = x * x + y * y
      along = merge((x * e1 + y * e2) / length2, 0.0_dp, length2 > law%limit2(k))
      return = law%limit(k) / sqrt(max(length2, law%limit2(k)))
      shrinkage1 = shrinkage1 + law%stiffness(k) * return * (e1 - along * x)
      shrinkage2 = shrinkage2 + law%stiffness(k) * return * (e2 - along * y)
    end do
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
