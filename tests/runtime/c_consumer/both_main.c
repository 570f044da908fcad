int bits_in_float(void);
int bits_in_double(void);

int main(void) { return bits_in_float() == 32 && bits_in_double() == 64 ? 0 : 1; }
