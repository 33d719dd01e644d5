// What the computer runs: the primes below PRIMES, the CRC-32 of the sieve, NUMBERS pseudo-random numbers sorted.
typedef unsigned u32;
typedef unsigned char u8;

#ifndef PRIMES
#define PRIMES 100
#endif
#ifndef NUMBERS
#define NUMBERS 12
#endif

#define OUTPUT (*(volatile u32 *)0x10000000)

static u8 composite[PRIMES];
static int numbers[NUMBERS];

static void text(const char *s) {
  while (*s) OUTPUT = (u8)*s++;
}

static void hexadecimal(u32 n) {
  for (int i = 28; i >= 0; i -= 4) OUTPUT = (u8) "0123456789abcdef"[n >> i & 15];
}

static void decimal(int n) {
  static const int powers[] = {1000000000, 100000000, 10000000, 1000000, 100000, 10000, 1000, 100, 10, 1};
  int begun = 0;
  if (n < 0) {
    OUTPUT = '-';
    n = -n;
  }
  for (int i = n < 10000 ? 6 : 0; i < 10; i++) {
    int digit = 0;
    for (; n >= powers[i]; n -= powers[i]) digit++;
    begun |= digit | (i == 9);
    if (begun) OUTPUT = (u32)('0' + digit);
  }
}

static void sieve(void) {
  for (u32 i = 2; i < PRIMES; i++) {
    if (composite[i]) continue;
    decimal((int)i);
    OUTPUT = ' ';
    for (u32 k = i + i; k < PRIMES; k += i) composite[k] = 1;
  }
  OUTPUT = '\n';
}

static u32 crc(const u8 *from, u32 length) {
  u32 c = ~0u;
  while (length--) {
    c ^= *from++;
    for (int i = 0; i < 8; i++) c = c & 1 ? c >> 1 ^ 0xedb88320 : c >> 1;
  }
  return ~c;
}

// xorshift; numbers from -2048 to 2047
static void draw(void) {
  u32 n = 1;
  for (int i = 0; i < NUMBERS; i++) {
    n ^= n << 13;
    n ^= n >> 17;
    n ^= n << 5;
    numbers[i] = (int)n >> 20;
  }
}

static void sort(void) {
  for (int i = 1; i < NUMBERS; i++) {
    int n = numbers[i], k = i;
    for (; k > 0 && numbers[k - 1] > n; k--) numbers[k] = numbers[k - 1];
    numbers[k] = n;
  }
}

int main(void) {
  sieve();
  text("crc ");
  hexadecimal(crc(composite, PRIMES));
  text("\nsorted");
  draw();
  sort();
  for (int i = 0; i < NUMBERS; i++) {
    OUTPUT = ' ';
    decimal(numbers[i]);
  }
  text("\n");
  return 0;
}
