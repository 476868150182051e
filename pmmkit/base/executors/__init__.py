"""Where work runs: in this process, in several on this machine, or on a cluster.

Everything that does many things of a kind takes ``executor=``: nothing for what is usual there, a
number of processes on this machine, the address of a dask scheduler (``tcp://…``), or any
`concurrent.futures.Executor`. What is done and in which order its results are used does not depend
on it: the results are the same to the bit.

On this machine the processes are those of joblib's loky. They take as long to start as those of
`concurrent.futures` (2 s with all that reduces a run), and unlike these they do not run the user's
script again, so it needs no ``if __name__ == "__main__":`` on Windows or macOS.
"""
