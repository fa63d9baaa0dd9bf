//! What a renderer's function files may take for granted: the channels of a ray and the standard names.
//!
//! Source: the names and their meaning are those of Radiance's `rayinit.cal` and of its function materials; the
//! formulas are written from the meaning.

/// Direction of the ray, x; y and z follow. Unit length, towards the surface.
pub const DIRECTION: u32 = 1;
/// Surface normal, x; y and z follow.
pub const NORMAL: u32 = 4;
/// Point where the ray meets the surface, x; y and z follow.
pub const POSITION: u32 = 7;
/// Distance from the start of the path.
pub const TOTAL_DISTANCE: u32 = 10;
/// Ray dot product: cosine between the normal and the way back, -1 to 1.
pub const COSINE: u32 = 11;
/// Scale of the function's coordinates.
pub const SCALE: u32 = 12;
/// World origin, x; y and z follow.
pub const ORIGIN: u32 = 13;
/// World i unit vector, x; y and z follow.
pub const AXIS_I: u32 = 16;
/// World j unit vector, x; y and z follow.
pub const AXIS_J: u32 = 19;
/// World k unit vector, x; y and z follow.
pub const AXIS_K: u32 = 22;
/// Distance of this ray alone.
pub const RAY_DISTANCE: u32 = 25;
/// Local coordinate u of a mesh; v follows.
pub const MESH_UV: u32 = 26;
/// Perturbed normal, x; y and z follow. In function and data materials only, as all channels from here on: they are
/// reached by their names (`NxP`, `RdotP`, `CrP`, `DxA`…), not as `$28`.
pub const PERTURBED_NORMAL: u32 = 28;
/// Ray dot product with the perturbed normal.
pub const PERTURBED_COSINE: u32 = 31;
/// Perturbed material color, red; green and blue follow.
pub const PERTURBED_COLOR: u32 = 32;
/// Direction to the target light source of prism1 and prism2, x; y and z follow.
pub const SOURCE_DIRECTION: u32 = 35;

/// The highest channel that a file may ask for by its number.
pub const N_NUMBERED: u32 = 27;

/// The standard names.
pub(super) const DEFINITIONS: &str = r#"
{ the ray }
Dx = $1; Dy = $2; Dz = $3;
Nx = $4; Ny = $5; Nz = $6;
Px = $7; Py = $8; Pz = $9;
T = $10; Rdot = $11; S = $12; Ts = $25;
Tx = $13; Ty = $14; Tz = $15;
Ix = $16; Iy = $17; Iz = $18;
Jx = $19; Jy = $20; Jz = $21;
Kx = $22; Ky = $23; Kz = $24;
Lu = $26; Lv = $27;
NxP = $28; NyP = $29; NzP = $30; RdotP = $31;
CrP = $32; CgP = $33; CbP = $34;
DxA = $35; DyA = $36; DzA = $37;
D(n) = select(n, Dx, Dy, Dz);
N(n) = select(n, Nx, Ny, Nz);
P(n) = select(n, Px, Py, Pz);

{ real arguments }
AC = arg(0);
A1 = arg(1); A2 = arg(2); A3 = arg(3); A4 = arg(4); A5 = arg(5);
A6 = arg(6); A7 = arg(7); A8 = arg(8); A9 = arg(9); A10 = arg(10);

{ constants }
PI : 3.14159265358979323846;
DEGREE : PI / 180;
FTINY : 1e-7;

{ logic: true is above 0 }
not(p) : if(p, -1, 1);
and(p, q) : if(p, q, p);
or(p, q) : if(p, p, q);
xor(p, q) : if(p, if(q, -1, 1), q);
inside(low, x, high) : and(x - low, high - x);

{ numbers }
abs(x) : if(x, x, -x);
sgn(x) : if(x, 1, if(-x, -1, 0));
sq(x) : x * x;
frac(x) : x - floor(x);
mod(x, period) : x - period * floor(x / period);
tri(x, half) : abs(half - mod(x - half, 2 * half));
linterp(t, from, to) : (1 - t) * from + t * to;
bound(low, x, high) : if(low - x, low, if(x - high, high, x));
noop(x) : x;
clip(x) : bound(0, x, 1);
noneg(x) : if(x, x, 0);

{ functions that stay within their domain }
Acos(x) : acos(bound(-1, x, 1));
Asin(x) : asin(bound(-1, x, 1));
Atan2(y, x) : if(y * y + x * x, atan2(y, x), 0);
Exp(x) : if(-100 - x, 0, exp(x));
Sqrt(x) : if(x, sqrt(x), 0);

{ color to number; the weights are the luminances of Radiance's primaries }
red(r, g, b) : noneg(r);
green(r, g, b) : noneg(g);
blue(r, g, b) : noneg(b);
grey(r, g, b) : noneg(.265074126 * r + .670114631 * g + .064811243 * b);
clip_r(r, g, b) : clip(r);
clip_g(r, g, b) : clip(g);
clip_b(r, g, b) : clip(b);
clipgrey(r, g, b) : min(1, grey(r, g, b));

{ vectors as functions of 1, 2, 3 }
dot(a, b) : a(1) * b(1) + a(2) * b(2) + a(3) * b(3);
cross(n, a, b) : select(n, a(2) * b(3) - a(3) * b(2), a(3) * b(1) - a(1) * b(3), a(1) * b(2) - a(2) * b(1));

{ curves }
fade(near, far, distance) : far + if(16 - distance, (near - far) / (1 + distance * distance), 0);
bezier(p1, p2, p3, p4, t) :
	(1 - t) * (1 - t) * (1 - t) * p1 + 3 * t * (1 - t) * (1 - t) * p2 + 3 * t * t * (1 - t) * p3 + t * t * t * p4;
bspline(before, p0, p1, after, t) :
	((1 - t) * (1 - t) * (1 - t) * before + ((3 * t - 6) * t * t + 4) * p0
	+ (((3 - 3 * t) * t + 3) * t + 1) * p1 + t * t * t * after) / 6;

{ noise }
noise3a(x, y, z) : noise3x(x, y, z);
noise3b(x, y, z) : noise3y(x, y, z);
noise3c(x, y, z) : noise3z(x, y, z);
noise3d(n, x, y, z) : select(n, noise3x(x, y, z), noise3y(x, y, z), noise3z(x, y, z));
slope`std.(x, y, z, s, slope) : sgn(noise3(x / s, y / s, z / s)) * slope(x / s, y / s, z / s);
turbulence(x, y, z, s) :
	if(s - 1.01, 0, s * abs(noise3(x / s, y / s, z / s)) + turbulence(x, y, z, 2 * s));
turbulencex(x, y, z, s) :
	if(s - 1.01, 0, slope`std.(x, y, z, s, noise3x) + turbulencex(x, y, z, 2 * s));
turbulencey(x, y, z, s) :
	if(s - 1.01, 0, slope`std.(x, y, z, s, noise3y) + turbulencey(x, y, z, 2 * s));
turbulencez(x, y, z, s) :
	if(s - 1.01, 0, slope`std.(x, y, z, s, noise3z) + turbulencez(x, y, z, 2 * s));

{ normal deviate of a number in (0,1): Abramowitz and Stegun, 26.2.23 }
tail`std.(t) : t - ((.010328 * t + .802853) * t + 2.515517) / (((.001308 * t + .189269) * t + 1.432788) * t + 1);
half`std.(p) : tail`std.(sqrt(-2 * log(p)));
unif2norm(p) : if(.5 - p, -half`std.(p), half`std.(1 - p));
nrand(x) = unif2norm(rand(x));

{ coordinates in a plane: V lies above U, seen along -N }
across`std. = Nx * Nx + Ny * Ny;
U = if(across`std. - FTINY, (Nx * Py - Ny * Px) / across`std., Px);
V = if(across`std. - FTINY, Pz - Nz * (Nx * Px + Ny * Py) / across`std., Py);

{ coordinates about the perturbed normal; the last three real arguments point upwards }
upx`std. = arg(AC - 1) * NzP - arg(AC) * NyP;
upy`std. = arg(AC) * NxP - arg(AC - 2) * NzP;
upz`std. = arg(AC - 2) * NyP - arg(AC - 1) * NxP;
scale`std. = 1 / sqrt(sq(upx`std.) + sq(upy`std.) + sq(upz`std.));
vx`std. = scale`std. * upx`std.;
vy`std. = scale`std. * upy`std.;
vz`std. = scale`std. * upz`std.;
ux`std. = NyP * vz`std. - NzP * vy`std.;
uy`std. = NzP * vx`std. - NxP * vz`std.;
uz`std. = NxP * vy`std. - NyP * vx`std.;
Ldx(x, y, z) = x * ux`std. + y * uy`std. + z * uz`std.;
Ldy(x, y, z) = x * vx`std. + y * vy`std. + z * vz`std.;
Ldz(x, y, z) = x * NxP + y * NyP + z * NzP;
Idx = Ldx(-Dx, -Dy, -Dz);
Idy = Ldy(-Dx, -Dy, -Dz);
Idz = RdotP;
"#;
