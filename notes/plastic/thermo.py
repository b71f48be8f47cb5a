from proto2 import *
