// Where the core is, beside the program.
declare module "*.wasm" {
  const url: string;
  export default url;
}
